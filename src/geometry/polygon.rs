//! Polygons cut into triangles: concave ones, and those with holes by slit, without area won or lost.

use earcut::Earcut;

use super::DVec3;

/// Shares of the polygon's area below this are rounding: a corner on the line between its neighbors.
const FLAT: f64 = 1e-12;

/// Cuts polygons into triangles; kept between polygons for its memory.
pub struct Triangulator {
    earcut: Earcut<f64>,
    flat: Vec<[f64; 2]>,
    ears: Vec<u32>,
}

impl Default for Triangulator {
    fn default() -> Self {
        Self { earcut: Earcut::new(), flat: Vec::new(), ears: Vec::new() }
    }
}

/// Newell's vector: along the polygon's normal, as long as twice its area. Unit: that of `corners`,
/// squared.
pub fn newell(corners: &[DVec3]) -> DVec3 {
    let Some(&origin) = corners.first() else {
        return DVec3::ZERO;
    };
    let next = corners.iter().skip(1).chain(&corners[..1]);
    corners.iter().zip(next).map(|(&a, &b)| (a - origin).cross(b - origin)).sum()
}

impl Triangulator {
    /// Calls `put` for each triangle, with places in `corners`; all wind as the polygon does.
    ///
    /// Convex polygons become a fan from their first corner. Every corner is used, so that
    /// neighbors that share an edge share its ends. A polygon that is not flat is cut as its
    /// projection along Newell's vector; one without area, or that crosses itself, is cut somehow.
    pub fn cut(&mut self, corners: &[DVec3], mut put: impl FnMut([usize; 3])) {
        match corners.len() {
            0..3 => {}
            3 => put([0, 1, 2]),
            count => {
                self.project(corners);
                if count == 4 {
                    cut_quad(&self.flat, put);
                } else if is_fan(&self.flat) {
                    (2..count).for_each(|k| put([0, k - 1, k]));
                } else {
                    self.clip_ears(put);
                }
            }
        }
    }

    /// Drops the coordinate along which the polygon is narrowest, the others scaled to about 1,
    /// with its front to the viewer.
    fn project(&mut self, corners: &[DVec3]) {
        let origin = corners[0];
        let size =
            corners.iter().fold(0.0, |size: f64, &p| size.max((p - origin).abs().max_element()));
        let scale = if size > 0.0 { size.recip() } else { 1.0 };
        let scaled = |p: &DVec3| (*p - origin) * scale;
        let pairs = corners.iter().zip(corners.iter().skip(1).chain(&corners[..1]));
        let normal: DVec3 = pairs.map(|(a, b)| scaled(a).cross(scaled(b))).sum();
        let across = normal.abs();
        let (x, y, along) = if across.z >= across.x && across.z >= across.y {
            (0, 1, normal.z)
        } else if across.x >= across.y {
            (1, 2, normal.x)
        } else {
            (2, 0, normal.y)
        };
        let (x, y) = if along < 0.0 { (y, x) } else { (x, y) };
        self.flat.clear();
        self.flat.extend(corners.iter().map(|p| {
            let p = scaled(p);
            [p[x], p[y]]
        }));
    }

    fn clip_ears(&mut self, mut put: impl FnMut([usize; 3])) {
        self.earcut.earcut_slice(&self.flat, &[], &mut self.ears);
        let mut triangles: Vec<[usize; 3]> =
            self.ears.as_chunks::<3>().0.iter().map(|t| t.map(|k| k as usize)).collect();
        for triangle in &mut triangles {
            if double_area(&self.flat, *triangle) < 0.0 {
                triangle.swap(1, 2);
            }
        }
        restore_left_out(self.flat.len(), &mut triangles);
        triangles.into_iter().for_each(&mut put);
    }
}

/// Twice the signed area, positive for a front.
fn double_area(flat: &[[f64; 2]], [a, b, c]: [usize; 3]) -> f64 {
    let [ax, ay] = flat[a];
    let [bx, by] = flat[b];
    let [cx, cy] = flat[c];
    (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
}

/// From the first corner if that leaves no part outside, else from the second: one of a simple
/// quadrangle's diagonals always lies inside.
fn cut_quad(flat: &[[f64; 2]], mut put: impl FnMut([usize; 3])) {
    let least = |[t, u]: [[usize; 3]; 2]| double_area(flat, t).min(double_area(flat, u));
    let (first, second) = ([[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]);
    let is_inside = least(first) > FLAT || least(first) >= least(second);
    (if is_inside { first } else { second }).into_iter().for_each(&mut put);
}

/// Whether the triangles from the first corner are all fronts.
fn is_fan(flat: &[[f64; 2]]) -> bool {
    (2..flat.len()).all(|k| double_area(flat, [0, k - 1, k]) > FLAT)
}

/// Ear clipping leaves out corners on the line between their neighbors: the triangle at that line is
/// cut in more.
fn restore_left_out(count: usize, triangles: &mut Vec<[usize; 3]>) {
    let mut is_used = vec![false; count];
    triangles.iter().flatten().for_each(|&corner| is_used[corner] = true);
    let Some(start) = is_used.iter().position(|&used| used) else {
        return;
    };
    let mut before = start;
    for step in 1..=count {
        let here = (start + step) % count;
        if is_used[here] {
            let left_out: Vec<usize> = between(before, here, count).collect();
            if !left_out.is_empty() {
                split_edge([before, here], &left_out, triangles);
            }
            before = here;
        }
    }
}

/// Corners after `from` and before `to`, around the polygon.
fn between(from: usize, to: usize, count: usize) -> impl Iterator<Item = usize> {
    let steps = (to + count - from - 1) % count;
    (1..=steps).map(move |step| (from + step) % count)
}

fn split_edge([from, to]: [usize; 2], left_out: &[usize], triangles: &mut Vec<[usize; 3]>) {
    let turned = |[a, b, c]: [usize; 3]| [[a, b, c], [b, c, a], [c, a, b]];
    let found = triangles.iter().enumerate().find_map(|(at, &triangle)| {
        turned(triangle).into_iter().find(|&[a, b, _]| a == from && b == to).map(|t| (at, t[2]))
    });
    let Some((at, apex)) = found else {
        return;
    };
    let mut last = from;
    for &corner in left_out {
        triangles.push([last, corner, apex]);
        last = corner;
    }
    triangles[at] = [last, to, apex];
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::random::Random;

    fn cut(corners: &[DVec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        Triangulator::default().cut(corners, |t| triangles.push(t));
        triangles
    }

    fn area(corners: &[DVec3]) -> f64 {
        let doubled = |t: &[usize; 3]| {
            (corners[t[1]] - corners[t[0]]).cross(corners[t[2]] - corners[t[0]]).length()
        };
        cut(corners).iter().map(doubled).sum::<f64>() / 2.0
    }

    /// Area of the triangles over Newell's, less 1, for the worst first corner.
    fn worst_error(polygon: &[DVec3]) -> f64 {
        let expected = newell(polygon).length() / 2.0;
        let turned = |first: usize| {
            let corners = [&polygon[first..], &polygon[..first]].concat();
            (area(&corners) / expected - 1.0).abs()
        };
        (0..polygon.len()).map(turned).fold(0.0, f64::max)
    }

    fn flat(points: &[[f64; 2]]) -> Vec<DVec3> {
        points.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
    }

    /// A star-shaped polygon of up to 40 corners around (0, 0): simple, and mostly concave.
    fn star(least: usize, random: &mut Random) -> Vec<[f64; 2]> {
        let count = least + random.below(41 - least);
        let corner = |k: usize, random: &mut Random| {
            let angle = (k as f64 + 0.9 * random.unit()) / count as f64 * std::f64::consts::TAU;
            let radius = 1.0 + 9.0 * random.unit();
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..count).map(|k| corner(k, random)).collect()
    }

    /// A sheared comb whose teeth are of random length: simple, and not star-shaped.
    fn comb(random: &mut Random) -> Vec<[f64; 2]> {
        let teeth = 2 + random.below(12);
        let mut points = vec![[0.0, 0.0], [teeth as f64, 0.0]];
        for k in (0..teeth).rev() {
            let (right, left) = (k as f64 + 0.9 - 0.3 * random.unit(), k as f64 + 0.1);
            let (top, floor) = (1.0 + 5.0 * random.unit(), 0.2 + 0.5 * random.unit());
            points.extend([[right, top], [left, top], [left - 0.05, floor]]);
        }
        let shear = 4.0 * random.unit() - 2.0;
        points.into_iter().map(|[x, y]| [x + shear * y, y]).collect()
    }

    /// The polygon with a hole inside of its kernel, joined by a slit.
    fn with_hole(outline: Vec<[f64; 2]>, random: &mut Random) -> Vec<[f64; 2]> {
        let count = 3 + random.below(6);
        let hole = (0..count).map(|k| {
            let angle = -(k as f64) / count as f64 * std::f64::consts::TAU;
            let radius = 0.1 + 0.4 * random.unit();
            [radius * angle.cos(), radius * angle.sin()]
        });
        let hole: Vec<[f64; 2]> = hole.collect();
        // The hole's first corner lies on the x axis: the slit goes to the corner nearest to it in
        // angle, which no edge crosses in a star.
        let nearest = (0..outline.len())
            .min_by(|&a, &b| {
                let angle = |k: usize| outline[k][1].atan2(outline[k][0]).abs();
                angle(a).total_cmp(&angle(b))
            })
            .unwrap_or(0);
        let mut points = outline[nearest..].to_vec();
        points.extend(&outline[..=nearest]);
        points.extend(&hole);
        points.push(hole[0]);
        points
    }

    /// Turned, moved, and of a size between a micrometer and ten meters.
    fn placed(points: &[[f64; 2]], random: &mut Random) -> Vec<DVec3> {
        let axis = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, random.unit() - 0.5);
        let turn = glam::DQuat::from_axis_angle(axis.normalize_or(DVec3::X), 7.0 * random.unit());
        let size = 10f64.powf(7.0 * random.unit() - 4.0);
        let shift = DVec3::new(random.unit(), random.unit(), random.unit()) * size * 10.0;
        points.iter().map(|&[x, y]| turn * DVec3::new(x, y, 0.0) * size + shift).collect()
    }

    #[test]
    fn ten_thousand_simple_polygons_keep_their_area() {
        let mut random = Random(1);
        for case in 0..10_000 {
            let points = match case % 3 {
                0 => star(4, &mut random),
                1 => comb(&mut random),
                _ => {
                    // With 8 corners no edge comes as near to the center as the hole is wide.
                    let outline = star(8, &mut random);
                    with_hole(outline, &mut random)
                }
            };
            let corners = placed(&points, &mut random);
            // All first corners of a few, one of the others.
            let first = random.below(corners.len());
            let turned = [&corners[first..], &corners[..first]].concat();
            let error = if case < 300 {
                worst_error(&corners)
            } else {
                (area(&turned) / newell(&turned).length() * 2.0 - 1.0).abs()
            };
            assert!(error < 1e-6, "case {case}: {error:e}");
            assert_eq!(cut(&corners).len(), corners.len() - 2, "case {case}");
        }
    }

    #[test]
    fn a_u_a_dart_and_a_frame_keep_their_area() {
        let u = [
            [0., 0.],
            [50., 0.],
            [50., 40.],
            [40., 40.],
            [40., 10.],
            [10., 10.],
            [10., 40.],
            [0., 40.],
        ];
        assert!((newell(&flat(&u)).length() / 2.0 - 1100.0).abs() < 1e-9);
        assert!(worst_error(&flat(&u)) < 1e-14);
        let dart = [[0., 0.], [10., -4.], [3., 0.], [10., 4.]];
        assert!(worst_error(&flat(&dart)) < 1e-14);
        let frame = [
            [0., 0.],
            [10., 0.],
            [10., 10.],
            [0., 10.],
            [0., 0.],
            [2., 2.],
            [2., 8.],
            [8., 8.],
            [8., 2.],
            [2., 2.],
        ];
        assert!((newell(&flat(&frame)).length() / 2.0 - 64.0).abs() < 1e-12);
        assert!(worst_error(&flat(&frame)) < 1e-14);
    }

    /// A corner in the middle of an edge is a neighbor's corner too: left out, light would leak
    /// between them.
    #[test]
    fn corners_on_straight_edges_stay() {
        let square = [
            [0., 0.],
            [1., 0.],
            [2., 0.],
            [3., 0.],
            [3., 1.],
            [3., 3.],
            [2., 3.],
            [0., 3.],
            [0., 2.],
        ];
        let triangles = cut(&flat(&square));
        assert_eq!(triangles.len(), 7);
        assert!(worst_error(&flat(&square)) < 1e-14);
        for k in 0..square.len() {
            let edge = [k, (k + 1) % square.len()];
            let has_edge = |t: &&[usize; 3]| (0..3).any(|i| [t[i], t[(i + 1) % 3]] == edge);
            assert_eq!(triangles.iter().filter(has_edge).count(), 1, "edge {edge:?}");
        }
    }

    #[test]
    fn convex_polygons_are_fans_of_their_first_corner() {
        let pentagon = [[0., 0.], [2., 0.], [3., 1.], [1., 3.], [-1., 1.]];
        assert_eq!(cut(&flat(&pentagon)), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert_eq!(cut(&flat(&pentagon[..4])), [[0, 1, 2], [0, 2, 3]]);
    }

    /// Not flat, without area, crossing itself: triangles all the same, of finite corners.
    #[test]
    fn odd_polygons_are_cut_somehow() {
        let saddle =
            [DVec3::ZERO, DVec3::new(1., 0., 1.), DVec3::new(1., 1., 0.), DVec3::new(0., 1., 1.)];
        assert_eq!(cut(&saddle).len(), 2);
        let line: Vec<DVec3> = (0..6).map(|k| DVec3::X * f64::from(k % 4)).collect();
        assert!(area(&line) == 0.0);
        assert!(area(&[DVec3::ONE; 7]) == 0.0);
        let bow = flat(&[[0., 0.], [2., 2.], [2., 0.], [0., 2.], [-1., 1.]]);
        assert!(cut(&bow).iter().flatten().all(|&k| k < 5));
        assert!(
            area(&flat(&[
                [0., 0.],
                [1e-200, 0.],
                [1e-200, 1e-200],
                [0., 1e-200],
                [-1e-201, 1e-201]
            ]))
            .is_finite()
        );
    }
}
