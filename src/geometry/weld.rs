//! Positions that are one, found in time that grows with their number.

use super::DVec3;

/// No place.
const NONE: u32 = u32::MAX;

/// Keeps the first of the positions that are one, drops those that are not `used`, and tells for each
/// old place the new one.
///
/// Positions are one if they are exactly equal, or no farther than `weld_mm` from the one kept.
/// Places of dropped positions are meaningless.
pub fn weld(positions: &mut Vec<DVec3>, used: &[bool], weld_mm: f64) -> Vec<u32> {
    let mut grid = WeldGrid::new(positions.len(), weld_mm);
    let mut new_places = vec![NONE; positions.len()];
    let mut kept = 0;
    for old in 0..positions.len() {
        if !used[old] {
            continue;
        }
        let position = positions[old];
        let found = grid.find(position, &positions[..kept]);
        new_places[old] = found.unwrap_or_else(|| {
            positions[kept] = position;
            grid.insert(position, kept as u32);
            kept += 1;
            kept as u32 - 1
        });
    }
    positions.truncate(kept);
    positions.shrink_to_fit();
    new_places
}

/// Cells of the welding distance, or one for each position, hashed into lists.
struct WeldGrid {
    weld_mm: f64,
    /// First place of each list.
    heads: Vec<u32>,
    /// The next place in its list, for each place kept.
    next: Vec<u32>,
}

impl WeldGrid {
    fn new(count: usize, weld_mm: f64) -> Self {
        let lists = (count + count / 2).next_power_of_two();
        Self { weld_mm, heads: vec![NONE; lists], next: Vec::new() }
    }

    /// The first place kept that is one with `position`.
    fn find(&self, position: DVec3, kept: &[DVec3]) -> Option<u32> {
        if self.weld_mm > 0.0 {
            let square = self.weld_mm * self.weld_mm;
            let is_near = |place: &u32| kept[*place as usize].distance_squared(position) <= square;
            let cell = self.cell(position);
            let around = (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
            let cells = around.map(|[x, y, z]| {
                let [cx, cy, cz] = cell;
                [cx.wrapping_add(x), cy.wrapping_add(y), cz.wrapping_add(z)]
            });
            cells.filter_map(|cell| self.list(cell).find(is_near)).min()
        } else {
            self.list(self.cell(position)).find(|&place| kept[place as usize] == position)
        }
    }

    fn insert(&mut self, position: DVec3, place: u32) {
        let list = self.list_of(self.cell(position));
        self.next.push(self.heads[list]);
        self.heads[list] = place;
    }

    fn list(&self, cell: [i64; 3]) -> impl Iterator<Item = u32> {
        let known = |place: u32| (place != NONE).then_some(place);
        let first = known(self.heads[self.list_of(cell)]);
        std::iter::successors(first, move |&place| known(self.next[place as usize]))
    }

    fn cell(&self, position: DVec3) -> [i64; 3] {
        if self.weld_mm > 0.0 {
            // Far out, cells end at the largest whole number: slow, not wrong.
            position.to_array().map(|x| (x / self.weld_mm).floor() as i64)
        } else {
            // Adding 0 makes −0 and 0 the same.
            position.to_array().map(|x| (x + 0.0).to_bits() as i64)
        }
    }

    fn list_of(&self, cell: [i64; 3]) -> usize {
        let mix = |hash: u64, x: i64| {
            (hash.rotate_left(23) ^ x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        };
        let hash = cell.into_iter().fold(0, mix);
        (hash ^ (hash >> 32)) as usize & (self.heads.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn welded(positions: &[[f64; 3]], weld_mm: f64) -> (Vec<DVec3>, Vec<u32>) {
        let mut positions: Vec<DVec3> = positions.iter().map(|&p| DVec3::from_array(p)).collect();
        let used = vec![true; positions.len()];
        let places = weld(&mut positions, &used, weld_mm);
        (positions, places)
    }

    #[test]
    fn equal_positions_are_one_and_neighbors_are_not() {
        let next = 1.0f64.next_up();
        let (kept, places) =
            welded(&[[1., 0., 2.], [next, 0., 2.], [1., -0., 2.], [next, 0., 2.]], 0.0);
        assert_eq!(kept.len(), 2);
        assert_eq!(places, [0, 1, 0, 1]);
    }

    /// Also across the borders of cells, and never farther than asked for.
    #[test]
    fn near_positions_are_one() {
        let (kept, places) =
            welded(&[[0.99, 0., 0.], [1.01, 0., 0.], [1.12, 0., 0.], [-5., -5., -5.]], 0.1);
        assert_eq!(places, [0, 0, 1, 2]);
        assert_eq!(kept[0], DVec3::new(0.99, 0., 0.));
        // Brute force on a cloud.
        let cloud: Vec<[f64; 3]> = (0..400)
            .map(|k| [0.377, 0.619, 0.811].map(|step: f64| (f64::from(k) * step).fract()))
            .collect();
        let (kept, _) = welded(&cloud, 0.1);
        let mut expected: Vec<DVec3> = Vec::new();
        for p in cloud.iter().map(|&p| DVec3::from_array(p)) {
            if expected.iter().all(|q| q.distance(p) > 0.1) {
                expected.push(p);
            }
        }
        assert_eq!(kept, expected);
    }

    #[test]
    fn unused_positions_are_dropped() {
        let mut positions = vec![DVec3::X, DVec3::Y, DVec3::Z];
        let places = weld(&mut positions, &[false, true, true], 0.0);
        assert_eq!(positions, [DVec3::Y, DVec3::Z]);
        assert_eq!(places[1..], [0, 1]);
    }
}
