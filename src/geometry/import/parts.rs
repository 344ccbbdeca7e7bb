//! Groups, objects and materials: which faces a name stands for.

use std::collections::HashMap;
use std::ops::Range;

use super::encoding::{is_same_name, readable};
use super::{MeshFault, MeshResult, Selection};
use crate::geometry::normals::Smoothing;

/// Names of one kind, numbered in the file's order.
#[derive(Debug, Default, PartialEq)]
pub(super) struct PartNames {
    numbers: HashMap<Vec<u8>, u32>,
    names: Vec<Vec<u8>>,
    has_faces: Vec<bool>,
}

impl PartNames {
    pub fn number(&mut self, name: &[u8]) -> u32 {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let number = self.names.len() as u32;
        self.numbers.insert(name.to_owned(), number);
        self.names.push(name.to_owned());
        self.has_faces.push(false);
        number
    }

    /// Those that have faces, for people.
    pub fn with_faces(&self) -> impl Iterator<Item = String> {
        self.names
            .iter()
            .zip(&self.has_faces)
            .filter(|(_, has)| **has)
            .map(|(name, _)| readable(name))
    }

    fn list(&self) -> String {
        let names: Vec<String> = self.with_faces().collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    }

    /// For each number, whether its name is the wanted one; or else, of a group, one of its words
    /// (`g lens outer` puts faces into two groups).
    fn wanted(&self, wanted: &[u8], by: impl Fn(&[u8], &[u8]) -> bool) -> Vec<bool> {
        self.names.iter().map(|name| by(name, wanted)).collect()
    }

    fn wanted_groups(&self, wanted: &[u8]) -> Vec<bool> {
        let whole = self.wanted(wanted, is_same_name);
        let has_faces = |(number, is_wanted): (usize, &bool)| *is_wanted && self.has_faces[number];
        if whole.iter().enumerate().any(has_faces) {
            return whole;
        }
        self.wanted(wanted, |name, wanted| {
            name.split(u8::is_ascii_whitespace).any(|word| is_same_name(word, wanted))
        })
    }
}

/// What holds for the polygons from `first` to the next run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PolygonRun {
    pub first: u32,
    pub group: Option<u32>,
    pub object: Option<u32>,
    pub material: Option<u32>,
    pub smoothing: Smoothing,
}

impl PolygonRun {
    pub const START: Self = Self {
        first: 0,
        group: None,
        object: None,
        material: None,
        smoothing: Smoothing::ByCrease,
    };
}

/// All names, and where they hold.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Parts {
    pub groups: PartNames,
    pub objects: PartNames,
    pub materials: PartNames,
    /// In the order of their first polygons.
    pub runs: Vec<PolygonRun>,
    /// How many polygons there are.
    pub polygons: u32,
}

impl Parts {
    /// A run from polygon `run.first` on, in the place of one that has no polygons.
    pub fn push(&mut self, run: PolygonRun) {
        if self.runs.last().is_some_and(|last| last.first == run.first) {
            self.runs.pop();
        }
        self.runs.push(run);
    }

    /// To be called once `polygons` are all there.
    pub fn note_faces(&mut self) {
        for at in 0..self.runs.len() {
            let run = self.runs[at];
            if !self.polygons_of(at).is_empty() {
                let note = |names: &mut PartNames, number: Option<u32>| {
                    number.into_iter().for_each(|number| names.has_faces[number as usize] = true);
                };
                note(&mut self.groups, run.group);
                note(&mut self.objects, run.object);
                note(&mut self.materials, run.material);
            }
        }
    }

    pub fn polygons_of(&self, run: usize) -> Range<u32> {
        let end = self.runs.get(run + 1).map_or(self.polygons, |next| next.first);
        self.runs[run].first..end.max(self.runs[run].first)
    }

    /// The runs that are wanted, or `None` for all.
    ///
    /// Errors: no polygon has the names, with those that are there.
    pub fn select(&self, selection: &Selection) -> MeshResult<Option<Vec<usize>>> {
        let Selection { group, object, material } = selection;
        if group.is_none() && object.is_none() && material.is_none() {
            return Ok(None);
        }
        let objects = object.as_ref().map(|name| self.objects.wanted(name, is_same_name));
        let materials = material.as_ref().map(|name| self.materials.wanted(name, is_same_name));
        let rest = |run: &PolygonRun| has(&objects, run.object) && has(&materials, run.material);
        let groups = group.as_ref().map(|name| self.groups.wanted_groups(name));
        let mut chosen = self.runs_where(|run| rest(run) && has(&groups, run.group));
        if chosen.is_empty() {
            let named = group.as_ref().map(|name| self.objects.wanted(name, is_same_name));
            chosen = self.runs_where(|run| rest(run) && has(&named, run.object));
        }
        if chosen.is_empty() { Err(self.unknown(selection)) } else { Ok(Some(chosen)) }
    }

    fn runs_where(&self, is_wanted: impl Fn(&PolygonRun) -> bool) -> Vec<usize> {
        let has_polygons = |&run: &usize| !self.polygons_of(run).is_empty();
        (0..self.runs.len())
            .filter(has_polygons)
            .filter(|&run| is_wanted(&self.runs[run]))
            .collect()
    }

    fn unknown(&self, selection: &Selection) -> MeshFault {
        let Selection { group, object, material } = selection;
        let asked = [("group", group), ("object", object), ("material", material)];
        let asked = asked.into_iter().filter_map(|(kind, name)| Some((kind, name.as_ref()?)));
        let asked: Vec<String> =
            asked.map(|(kind, name)| format!("{kind} \"{}\"", readable(name))).collect();
        MeshFault::file(format!(
            "no faces in {} (groups: {}; objects: {}; materials: {})",
            asked.join(" and "),
            self.groups.list(),
            self.objects.list(),
            self.materials.list()
        ))
    }
}

fn has(wanted: &Option<Vec<bool>>, number: Option<u32>) -> bool {
    wanted.as_ref().is_none_or(|wanted| number.is_some_and(|number| wanted[number as usize]))
}
