//! A sweep shared out among processes.

use std::fmt;
use std::str::FromStr;

/// Part `number` of `count`: every `count`-th view, so that all parts are as long.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    /// 1 to `count`.
    pub number: usize,
    /// Parts of the sweep, ≥ 1.
    pub count: usize,
}

/// Beyond this a slash was mistyped.
const MOST: usize = 100_000;

impl Shard {
    /// Whether the view is of this part; `index` is 1-based.
    pub fn has(self, index: usize) -> bool {
        (index - 1) % self.count == self.number - 1
    }

    /// Digits are filled up so that names sort by number.
    pub fn manifest_name(self) -> String {
        let digits = self.count.to_string().len();
        format!("manifest.{:0digits$}-of-{}.json", self.number, self.count)
    }

    /// The part that a manifest's name stands for.
    pub fn of_manifest_name(name: &str) -> Option<Self> {
        let (number, count) =
            name.strip_prefix("manifest.")?.strip_suffix(".json")?.split_once("-of-")?;
        let shard = Self { number: number.parse().ok()?, count: count.parse().ok()? };
        (shard.is_valid() && shard.manifest_name() == name).then_some(shard)
    }

    fn is_valid(self) -> bool {
        (1..=MOST).contains(&self.count) && (1..=self.count).contains(&self.number)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(number, count)| {
            Some(Self { number: number.parse().ok()?, count: count.parse().ok()? })
        });
        parsed
            .filter(|shard| shard.is_valid())
            .ok_or_else(|| format!("expected NUMBER/COUNT such as 3/40, up to {MOST} shards"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_out_every_view_once() {
        for count in [1, 3, 40] {
            let shards = (1..=count).map(|number| Shard { number, count });
            let shards: Vec<Shard> = shards.collect();
            for index in 1..100 {
                assert_eq!(shards.iter().filter(|s| s.has(index)).count(), 1);
            }
        }
    }

    #[test]
    fn names_and_texts_read_back() {
        let shard: Shard = "3/40".parse().unwrap();
        assert_eq!(shard.manifest_name(), "manifest.03-of-40.json");
        assert_eq!(Shard::of_manifest_name("manifest.03-of-40.json"), Some(shard));
        assert_eq!(shard.to_string(), "3/40");
        for wrong in ["", "3", "0/4", "5/4", "1/0", "-1/4", "3/40/2", "1/999999"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
        for wrong in ["manifest.json", "manifest.3-of-40.json", "manifest.41-of-40.json"] {
            assert_eq!(Shard::of_manifest_name(wrong), None, "{wrong}");
        }
    }
}
