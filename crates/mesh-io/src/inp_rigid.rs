//! Rigid bodies of an Abaqus input file: the elements of the sets that `*Rigid Body` names.
//!
//! A set has members of a part, of an instance, or of a file without these. They are listed by `*Elset`, by numbers,
//! ranges and the names of other sets, or stand below `*Element, elset=...`. The assembly has sets of its own, each
//! with members of an instance; `instance.set` is the set of an instance there.
//!
//! Source: "Abaqus Keywords Reference Guide", `*RIGID BODY` and `*ELSET`.

use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use crate::ReadError;
use crate::inp_keyword::{INP, InpLine, InpLines, Keyword};
use crate::text::{Line, Lines, number, placed_fields, quoted};

/// Owner of the elements or of the name of a set. Names are in upper case.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum SetOwner {
    Part(String),
    Instance(String),
    /// The assembly, or a file without parts.
    Outside,
}

/// Names of sets that are rigid, and all sets that `*Elset` lists, whose members are not read yet.
#[derive(Debug, Default)]
pub(crate) struct RigidBodies<'a> {
    rigid: Vec<(SetOwner, String)>,
    sets: Vec<ListedSet<'a>>,
}

/// Set that `*Elset` lists.
#[derive(Debug)]
struct ListedSet<'a> {
    owner: SetOwner,
    /// Name in upper case.
    name: String,
    /// Owner of its members.
    members: SetOwner,
    /// True if its lines are ranges.
    is_generated: bool,
    /// Lines below its keyword.
    lines: Lines<'a>,
}

/// Rigid elements of a body.
#[derive(Debug, Default)]
pub(crate) struct RigidElements {
    /// Names of the sets that are rigid, in upper case.
    sets: BTreeSet<String>,
    /// Ranges of the numbers that rigid sets list, apart and ascending.
    numbers: Vec<RangeInclusive<u64>>,
    /// Ranges whose numbers are more than 1 apart.
    strides: Vec<(RangeInclusive<u64>, u64)>,
}

/// Elements of one keyword, of one part.
#[derive(Debug)]
pub(crate) struct ElementList {
    /// Number of the part.
    pub(crate) part: usize,
    /// Name of the set that the keyword puts them in, in upper case.
    pub(crate) set: Option<String>,
    /// True if they are rigid by their type.
    pub(crate) is_rigid: bool,
    /// Ranges of their numbers, in the order of the file.
    numbers: Vec<RangeInclusive<u64>>,
}

/// Member of a set.
enum Member {
    Numbers(RangeInclusive<u64>, u64),
    Set(String),
}

impl SetOwner {
    pub(crate) fn part(name: &str) -> Self {
        Self::Part(name.to_ascii_uppercase())
    }

    pub(crate) fn instance(name: &str) -> Self {
        Self::Instance(name.to_ascii_uppercase())
    }
}

impl<'a> RigidBodies<'a> {
    /// Reads a keyword of an owner, given the lines below it.
    pub(crate) fn read_keyword(
        &mut self,
        keyword: &Keyword<'_>,
        owner: SetOwner,
        below: &Lines<'a>,
    ) {
        let Some(name) = keyword.value("ELSET").map(str::to_ascii_uppercase) else { return };
        if keyword.is("RIGIDBODY") {
            self.rigid.push((owner, name));
        } else if keyword.is("ELSET") {
            let instance = keyword.value("INSTANCE").map(SetOwner::instance);
            self.sets.push(ListedSet {
                members: instance.unwrap_or_else(|| owner.clone()),
                owner,
                name,
                is_generated: keyword.has("GENERATE"),
                lines: below.clone(),
            });
        }
    }

    /// Returns the rigid elements of a body, to which some owners belong.
    pub(crate) fn elements(
        &self,
        is_own: impl Fn(&SetOwner) -> bool,
    ) -> Result<RigidElements, ReadError> {
        let mut elements = RigidElements::default();
        let (mut open, mut seen) = (self.rigid.clone(), BTreeSet::new());
        while let Some((owner, name)) = open.pop() {
            let is_of_body = is_own(&owner);
            let is_of_others = !is_of_body && owner != SetOwner::Outside;
            if is_of_others || !seen.insert((owner.clone(), name.clone())) {
                continue;
            }

            // Members of other bodies lead to none of this one.
            let mut members = Vec::new();
            if owner == SetOwner::Outside {
                members.extend(dotted_member(&name));
            }
            for set in self.sets_of(&owner, &name, &is_own) {
                if is_own(&set.members) || set.members == SetOwner::Outside {
                    let own = set.members()?.into_iter();
                    members.extend(own.map(|member| (set.members.clone(), member)));
                }
            }
            for (owner, member) in members {
                match member {
                    Member::Set(name) => open.push((owner, name)),
                    Member::Numbers(range, step) if is_own(&owner) => elements.push(range, step),
                    Member::Numbers(..) => {}
                }
            }
            if is_of_body {
                elements.sets.insert(name);
            }
        }
        elements.merge();
        Ok(elements)
    }

    /// Returns the listed sets of a name: of a body, those of all that belongs to it, as a part does to its instance.
    fn sets_of(
        &self,
        owner: &SetOwner,
        name: &str,
        is_own: &impl Fn(&SetOwner) -> bool,
    ) -> impl Iterator<Item = &ListedSet<'a>> {
        let is_of_body = is_own(owner);
        let is_same = move |set: &&ListedSet<'_>| {
            set.name == name && if is_of_body { is_own(&set.owner) } else { set.owner == *owner }
        };
        self.sets.iter().filter(is_same)
    }
}

/// Returns the element or set of an instance that a name of the assembly is.
fn dotted_member(name: &str) -> Option<(SetOwner, Member)> {
    let (instance, member) = name.split_once('.')?;
    let member = match number(member.as_bytes()) {
        Some(number) => Member::Numbers(number..=number, 1),
        None => Member::Set(member.to_owned()),
    };
    Some((SetOwner::instance(instance), member))
}

impl ListedSet<'_> {
    /// Reads the members.
    fn members(&self) -> Result<Vec<Member>, ReadError> {
        let mut members = Vec::new();
        for line in InpLines::new(self.lines.clone()) {
            let InpLine::Data(line) = line else { break };
            if self.is_generated {
                members.push(range(&line)?);
                continue;
            }
            let fields = placed_fields(line.text, line.start, b',');
            for field in fields.filter(|field| !field.text.is_empty()) {
                let name =
                    || String::from_utf8_lossy(field.text).trim_matches('"').to_ascii_uppercase();
                members.push(match number(field.text) {
                    Some(number) => Member::Numbers(number..=number, 1),
                    None => Member::Set(name()),
                });
            }
        }
        Ok(members)
    }
}

/// Reads a range: its first and last number, and the step between numbers.
fn range(line: &Line<'_>) -> Result<Member, ReadError> {
    let fields = placed_fields(line.text, line.start, b',');
    let fields = fields.filter(|field| !field.text.is_empty());
    let numbers: Option<Vec<u64>> = fields.map(|field| number(field.text)).collect();
    match numbers.as_deref() {
        Some(&[first]) => Ok(Member::Numbers(first..=first, 1)),
        Some(&[first, last]) => Ok(Member::Numbers(first..=last, 1)),
        Some(&[first, last, step]) if step > 0 => Ok(Member::Numbers(first..=last, step)),
        _ => {
            let problem = format!("{} is no range of elements", quoted(line.text.trim_ascii()));
            Err(INP.on_line(line.number, problem))
        }
    }
}

impl RigidElements {
    /// Returns true if all of some elements are rigid.
    pub(crate) fn have(&self, list: &ElementList) -> bool {
        let in_set = || list.set.as_ref().is_some_and(|set| self.sets.contains(set));
        let mut numbers = list.numbers.iter().cloned().flatten();
        list.is_rigid || in_set() || numbers.all(|number| self.have_number(number))
    }

    fn have_number(&self, number: u64) -> bool {
        let place = self.numbers.partition_point(|range| *range.end() < number);
        let is_in_range = self.numbers.get(place).is_some_and(|range| range.contains(&number));
        let is_in_strides = |(range, step): &(RangeInclusive<u64>, u64)| {
            range.contains(&number) && (number - range.start()).is_multiple_of(*step)
        };
        is_in_range || self.strides.iter().any(is_in_strides)
    }

    fn push(&mut self, range: RangeInclusive<u64>, step: u64) {
        if step == 1 {
            self.numbers.push(range);
        } else {
            self.strides.push((range, step));
        }
    }

    /// Joins ranges that meet.
    fn merge(&mut self) {
        self.numbers.retain(|range| !range.is_empty());
        self.numbers.sort_unstable_by_key(|range| *range.start());
        let mut merged: Vec<RangeInclusive<u64>> = Vec::new();
        for range in self.numbers.drain(..) {
            match merged.last_mut() {
                Some(last) if *range.start() <= last.end().saturating_add(1) => {
                    *last = *last.start()..=*last.end().max(range.end());
                }
                _ => merged.push(range),
            }
        }
        self.numbers = merged;
    }
}

impl ElementList {
    /// Returns a list of no elements yet.
    pub(crate) fn new(part: usize, set: Option<&str>, is_rigid: bool) -> Self {
        Self { part, set: set.map(str::to_ascii_uppercase), is_rigid, numbers: Vec::new() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Adds the number of an element.
    pub(crate) fn push(&mut self, number: u64) {
        match self.numbers.last_mut() {
            Some(last) if last.end().checked_add(1) == Some(number) => {
                *last = *last.start()..=number;
            }
            _ => self.numbers.push(number..=number),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(set: &str, numbers: &[u64]) -> ElementList {
        let mut list = ElementList::new(0, Some(set), false);
        numbers.iter().for_each(|&number| list.push(number));
        list
    }

    /// Returns the rigid bodies of a file without parts.
    fn rigid_bodies(file: &str) -> RigidBodies<'_> {
        let mut lines = InpLines::new(Lines::new(file.as_bytes()));
        let mut bodies = RigidBodies::default();
        while let Some(line) = lines.next() {
            if let InpLine::Keyword(keyword) = line {
                bodies.read_keyword(&keyword, SetOwner::Outside, lines.rest());
            }
        }
        bodies
    }

    #[test]
    fn sets_have_the_numbers_ranges_and_sets_that_they_list() {
        let file = "*Elset, elset=a\n1, 2,\n\"b\", d\n*Elset, elset=B, generate\n5, 9, 2\n7, 8\n12\n\
                    *Elset, elset=a, gen\n15, 14\n16, 18, 1\n*Elset, elset=c\n10\n\
                    *Elset, elset=d\n3, A\n** end\n*Rigid Body, ref node=4, elset=A\n";
        let elements = rigid_bodies(file).elements(|_| true).expect("sets");
        let numbers: Vec<_> = (1..20).filter(|&number| elements.have_number(number)).collect();
        assert_eq!(numbers, [1, 2, 3, 5, 7, 8, 9, 12, 16, 17, 18]);
        assert!(elements.sets.iter().eq(["A", "B", "D"]), "{:?}", elements.sets);
    }

    #[test]
    fn elements_are_rigid_by_set_by_number_or_by_type() {
        let elements = RigidElements {
            sets: BTreeSet::from(["BONE".to_owned()]),
            numbers: vec![1..=4],
            strides: vec![(6..=u64::MAX, 4)],
        };
        assert!(elements.have(&list("bone", &[5])));
        assert!(elements.have(&list("skin", &[3, 4, 10, 1, 2])));
        for (number, expected) in [(5, false), (6, true), (12, false), (u64::MAX, false)] {
            assert_eq!(elements.have(&list("skin", &[number])), expected, "{number}");
        }
        assert!(!elements.have(&list("skin", &[3, 4, 5])));
        let shells = ElementList { is_rigid: true, ..list("skin", &[5]) };
        assert!(elements.have(&shells));
    }

    #[test]
    fn ranges_that_are_none_are_refused_by_line() {
        for line in ["1, 2, 0", "1, b", "1, 2, 3, 4", "-1, 2", ","] {
            let file = format!("*Elset, elset=a, generate\n{line}\n*Rigid Body, elset=a\n");
            let refusal = rigid_bodies(&file).elements(|_| true).expect_err(line).to_string();
            assert!(refusal.contains("line 2") && refusal.contains("no range"), "{refusal}");
        }
    }
}
