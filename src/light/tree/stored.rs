//! A tree as bytes, for who keeps it from one process to the next.

use std::io::{self, Read, Write};

use super::blocks::Blocks;
use super::levels::Levels;
use super::order::Order;
use super::{LightTree, Ordered, is_lambert};
use crate::light::RaySet;
use crate::light::stored::{read_words, write_words};

impl LightTree {
    /// What takes long to build, as [`LightTree::read`] takes it: 4 bytes a sample, and up to 45 MB of
    /// tables.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let Ordered { blocks, levels, cones: _ } = &*self.ordered;
        let order = blocks.order();
        out.write_all(&(order.len() as u64).to_le_bytes())?;
        write_words(out, order.iter().map(|index| index.to_le_bytes()))?;
        levels.as_ref().map_or(Ok(()), |levels| levels.write(out))
    }

    /// The tree that [`LightTree::write`] wrote for the same samples, bit for bit.
    ///
    /// Errors: bytes that end too early, or that are of other samples. Whether a tree is the right one
    /// for samples of the same number cannot be seen in its bytes.
    pub fn read(set: &RaySet, from: &mut dyn Read) -> io::Result<LightTree> {
        let other = || io::Error::other("a tree of other samples");
        let mut count = [0; 8];
        from.read_exact(&mut count)?;
        let count = usize::try_from(u64::from_le_bytes(count)).ok();
        let count = count.filter(|count| *count <= set.samples.len()).ok_or_else(other)?;
        let mut indices = vec![0; count];
        read_words(from, count, indices.iter_mut(), u32::from_le_bytes)?;
        let order = Order::known(&set.samples, &indices).ok_or_else(other)?;
        drop(indices);
        let blocks = Blocks::new(set, &order);
        let ordered = match is_lambert(set) {
            true => {
                let levels = Levels::read(&blocks, order.depth, from)?;
                Ordered { levels, cones: None, blocks }
            }
            false => Ordered::with_cones(blocks),
        };
        Ok(LightTree::of(set, ordered.share(set)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Photometry;
    use crate::geometry::DVec3;
    use crate::light::{HitQuery, LightSum, RaySample};
    use crate::material::{Lobes, SpecularLobe};

    /// On a spiral, turned outward; every hundredth sends nothing.
    fn spiral(count: usize, exponent: f64) -> RaySet {
        let sample = |i: usize| {
            let t = i as f32 / count as f32;
            let (sin, cos) = (t * 90.0).sin_cos();
            let flux = if i % 100 == 7 { 0.0 } else { 1.0 + t };
            RaySample { position: [cos, sin, 4.0 * t], direction: [cos, sin, 0.0], flux }
        };
        let set = RaySet::new((0..count).map(sample).collect(), 100.0);
        set.with_exponent(exponent).unwrap()
    }

    fn sums(tree: &LightTree) -> Vec<LightSum> {
        let specular = vec![SpecularLobe { k_s: 0.4, n_s: 300.0 }];
        let lobes = Lobes { k_d: 0.3, n_d: 1.0, specular, ..Lobes::default() };
        let at = |i: i32| {
            let query = HitQuery {
                point: DVec3::new(3.0 + f64::from(i), f64::from(i % 3), 2.0),
                normal: DVec3::NEG_X,
                view: DVec3::new(-1.0, 0.1, 0.0).normalize(),
                lobes: &lobes,
                photometry: Photometry::Relative,
                reflects: true,
                transmits: false,
            };
            [0.0, 0.001, 0.1].map(|light_error| tree.sum(&query, light_error, None))
        };
        (0..8).flat_map(at).collect()
    }

    /// A set with other samples' memory, so that no tree is shared.
    fn apart(set: &RaySet) -> RaySet {
        RaySet { samples: set.samples.iter().copied().collect(), ..set.clone() }
    }

    #[test]
    fn a_tree_reads_back_to_the_bit() {
        for (count, exponent) in [(20_000, 1.0), (1000, 1.0), (1, 1.0), (20_000, 50.0)] {
            let set = spiral(count, exponent);
            let tree = LightTree::build(&set);
            let mut bytes = Vec::new();
            tree.write(&mut bytes).unwrap();

            let other = apart(&set);
            let read = LightTree::read(&other, &mut &*bytes).unwrap();
            assert_eq!(read.len(), tree.len());
            assert_eq!(sums(&read), sums(&tree), "{count} {exponent}");
            assert_eq!(read.memory_bytes(), tree.memory_bytes());

            let cut = LightTree::read(&apart(&set), &mut &bytes[..bytes.len() - 1]);
            assert!(cut.is_err(), "{count}");
        }
    }

    #[test]
    fn a_tree_of_other_samples_is_refused() {
        let mut bytes = Vec::new();
        LightTree::build(&spiral(5000, 1.0)).write(&mut bytes).unwrap();
        assert!(LightTree::read(&spiral(4000, 1.0), &mut &*bytes).is_err());
        bytes[8..12].copy_from_slice(&5000u32.to_le_bytes());
        assert!(LightTree::read(&spiral(5000, 1.0), &mut &*bytes).is_err(), "index");
        assert!(LightTree::read(&spiral(5000, 1.0), &mut &[0xff; 12][..]).is_err(), "count");
    }
}
