//! Lanes beside a reference line: they have widths that change, begin and end.

use serde::{Deserialize, Serialize};

use crate::Profile;

/// The lanes along a road. Places count along its reference line.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lanes {
    /// Middle of the lanes with the ids 0, to the left of the reference line, m.
    pub offset: Profile,
    /// The sections in order; the first holds from the start.
    pub sections: Vec<Section>,
    /// End of the last section, m.
    pub length_m: f64,
}

/// A stretch of road with the same lanes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Section {
    pub from_m: f64,
    /// Its lanes from right to left.
    pub lanes: Vec<Lane>,
    /// Number of these, at the end of the list, that lie to the left of the middle.
    pub left: usize,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lane {
    /// Its id, unique in the section.
    pub id: i32,
    /// Vehicles may drive on it.
    pub drivable: bool,
    /// Width along the road, m.
    pub width: Profile,
    /// The place of the lane that it continues among the lanes of the section before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<usize>,
    /// The place of the lane that continues it among the lanes of the next section.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<usize>,
}

/// A lane at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    pub id: i32,
    /// Its place among the lanes of its section, from the right.
    pub index: usize,
    /// It lies to the left of the middle.
    pub is_left: bool,
    /// Its middle, to the left of the reference line, m.
    pub center_m: f64,
    pub width_m: f64,
    /// Vehicles may drive on it.
    pub drivable: bool,
}

impl Lanes {
    /// The section at a place; the first and the last go on outside the road.
    pub fn section(&self, s_m: f64) -> usize {
        self.sections.partition_point(|section| section.from_m <= s_m).saturating_sub(1)
    }

    /// The lanes at a place: those to the right of the middle outwards, then those to the left.
    pub fn strips(&self, s_m: f64) -> impl Iterator<Item = Strip> + '_ {
        let s_m = s_m.clamp(0.0, self.length_m);
        let section = self.sections.get(self.section(s_m));
        let (lanes, left) = section.map_or((&[][..], 0), |s| (&s.lanes[..], s.left));
        let right = lanes.len() - left;
        let offset_m = self.offset.at(s_m);
        let side = move |sign: f64| {
            let mut edge_m = 0.0;
            move |(index, lane): (usize, &Lane)| {
                let width_m = lane.width.at(s_m).max(0.0);
                let center_m = offset_m + sign * (edge_m + 0.5 * width_m);
                edge_m += width_m;
                let Lane { id, drivable, .. } = *lane;
                Strip { id, index, is_left: sign > 0.0, center_m, width_m, drivable }
            }
        };
        let (to_right, to_left) = (side(-1.0), side(1.0));
        let numbered = lanes.iter().enumerate();
        numbered.clone().take(right).rev().map(to_right).chain(numbered.skip(right).map(to_left))
    }

    /// The lane of an id at a place.
    pub fn strip(&self, s_m: f64, id: i32) -> Option<Strip> {
        self.strips(s_m).find(|strip| strip.id == id)
    }

    /// The middle of the lane that has a place in a section, along the road, m. The profile follows the links of the
    /// lane to both sides. It keeps its last value where the lane has no neighbour. A lane without width at an end of
    /// its section has the edge of its neighbour there.
    pub fn center(&self, section: usize, index: usize) -> Profile {
        let mut parts: Vec<(usize, usize)> = self.chain((section, index), false).collect();
        parts.reverse();
        parts.extend(self.chain((section, index), true).skip(1));
        let mut profile = Profile::default();
        for (section, index) in parts {
            let from_m = self.sections[section].from_m;
            let part = self.center_in(section, index).moved(-from_m);
            let length_m = self.end_m(section) - from_m;
            if profile == Profile::default() && section > 0 {
                Profile::constant(part.at(0.0)).append_to(&mut profile, 0.0, from_m);
            }
            part.append_to(&mut profile, from_m, length_m);
            let ends_early = section + 1 < self.sections.len();
            if ends_early {
                let rest_m = self.length_m - from_m - length_m;
                Profile::constant(part.at(length_m)).append_to(
                    &mut profile,
                    from_m + length_m,
                    rest_m,
                );
            }
        }
        profile
    }

    /// The places, section and lane, of a lane and of those that continue it, or that it continues.
    pub fn chain(
        &self,
        from: (usize, usize),
        forward: bool,
    ) -> impl Iterator<Item = (usize, usize)> + '_ {
        std::iter::successors(Some(from), move |&(section, index)| {
            let lane = &self.sections[section].lanes[index];
            let next = if forward { Some(section + 1) } else { section.checked_sub(1) };
            let next = next.filter(|next| *next < self.sections.len());
            next.zip(if forward { lane.after } else { lane.before })
        })
    }

    fn end_m(&self, section: usize) -> f64 {
        self.sections.get(section + 1).map_or(self.length_m, |next| next.from_m)
    }

    /// The middle of a lane inside its section.
    fn center_in(&self, section: usize, index: usize) -> Profile {
        let Section { from_m, ref lanes, left } = self.sections[section];
        let right = lanes.len() - left;
        let inner = if index < right { index + 1..right } else { right..index };
        let sign = if index < right { -1.0 } else { 1.0 };
        let mut parts = vec![(1.0, &self.offset), (0.5 * sign, &lanes[index].width)];
        parts.extend(lanes[inner].iter().map(|lane| (sign, &lane.width)));
        Profile::sum(&parts, from_m, self.end_m(section))
    }

    /// True if the sections are in order, and each link leads to a lane.
    pub fn is_sound(&self) -> bool {
        let lanes = |section: Option<usize>| {
            section.and_then(|section| self.sections.get(section)).map_or(0, |s| s.lanes.len())
        };
        let fits = |(number, section): (usize, &Section)| {
            let (before, after) = (lanes(number.checked_sub(1)), lanes(Some(number + 1)));
            section.from_m < self.end_m(number)
                && section.left <= section.lanes.len()
                && section.lanes.iter().all(|lane| {
                    lane.before.is_none_or(|index| index < before)
                        && lane.after.is_none_or(|index| index < after)
                })
        };
        self.length_m > 0.0 && self.sections.iter().enumerate().all(fits)
    }

    /// True if the lanes are the same, with the same widths, all along.
    pub fn is_uniform(&self) -> bool {
        let widths = |section: &Section| {
            section.lanes.iter().all(|lane| lane.width.uniform(self.length_m).is_some())
        };
        self.sections.len() == 1
            && self.offset.uniform(self.length_m).is_some()
            && self.sections.iter().all(widths)
    }

    /// The lanes of a road that is driven from its end: what was left is right. The ids stay.
    pub fn reversed(&self) -> Self {
        let section = |(number, section): (usize, &Section)| Section {
            from_m: self.length_m - self.end_m(number),
            left: section.lanes.len() - section.left,
            lanes: section.lanes.iter().rev().map(|lane| self.turned(number, lane)).collect(),
        };
        let mut sections: Vec<Section> = self.sections.iter().enumerate().map(section).collect();
        sections.reverse();
        let offset = self.offset.reversed(self.length_m).negated();
        Self { offset, sections, length_m: self.length_m }
    }

    fn turned(&self, section: usize, lane: &Lane) -> Lane {
        let turn = |index: Option<usize>, section: Option<usize>| {
            let lanes = self.sections.get(section?)?.lanes.len();
            lanes.checked_sub(1 + index?)
        };
        Lane {
            width: lane.width.reversed(self.length_m),
            before: turn(lane.after, Some(section + 1)),
            after: turn(lane.before, section.checked_sub(1)),
            ..*lane
        }
    }

    /// Puts the lanes of the next road behind these. `links` are pairs of places in the last section and the first
    /// one of `next`.
    pub fn append(&mut self, next: &Self, links: &[(usize, usize)]) {
        let at_m = self.length_m;
        next.offset.append_to(&mut self.offset, at_m, next.length_m);
        let joint = self.sections.len();
        for section in &next.sections {
            let lane = |lane: &Lane| Lane { width: lane.width.clone().moved(at_m), ..*lane };
            let lanes = section.lanes.iter().map(lane).collect();
            self.sections.push(Section {
                from_m: at_m + section.from_m,
                lanes,
                left: section.left,
            });
        }
        self.length_m += next.length_m;
        for &(from, to) in links {
            if joint > 0 && joint < self.sections.len() {
                if let Some(lane) = self.sections[joint - 1].lanes.get_mut(from) {
                    lane.after = Some(to);
                }
                if let Some(lane) = self.sections[joint].lanes.get_mut(to) {
                    lane.before = Some(from);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stretch;

    fn width(from_m: f64, factors: [f64; 4]) -> Profile {
        Profile::new(vec![Stretch { from_m, factors }])
    }

    /// Two lanes to the right, a third from 100 m on, which widens over 50 m; one to the left.
    fn exit() -> Lanes {
        let lane = |id: i32, width: &Profile, before, after| Lane {
            id,
            drivable: true,
            width: width.clone(),
            before,
            after,
        };
        let (first, taper) =
            (width(0.0, [3.0, 0.0, 0.0, 0.0]), width(100.0, [0.0, 0.06, 0.0, 0.0]));
        let wide = [(-2, 0, 1), (-1, 1, 2), (1, 2, 3)];
        let before = wide.map(|(id, _, after)| lane(id, &first, None, Some(after)));
        let mut after = vec![lane(-3, &taper, None, None)];
        after.extend(wide.map(|(id, before, _)| lane(id, &first, Some(before), None)));
        Lanes {
            offset: Profile::new(vec![Stretch { from_m: 0.0, factors: [0.5, 0.0, 0.0, 0.0] }]),
            sections: vec![
                Section { from_m: 0.0, lanes: before.to_vec(), left: 1 },
                Section { from_m: 100.0, lanes: after, left: 1 },
            ],
            length_m: 150.0,
        }
    }

    fn centers(lanes: &Lanes, s_m: f64) -> Vec<(i32, f64, f64)> {
        let mut strips: Vec<Strip> = lanes.strips(s_m).collect();
        strips.sort_by_key(|strip| strip.index);
        strips.iter().map(|strip| (strip.id, strip.center_m, strip.width_m)).collect()
    }

    #[test]
    fn a_lane_begins() {
        let lanes = exit();
        assert_eq!(centers(&lanes, 50.0), [(-2, -4.0, 3.0), (-1, -1.0, 3.0), (1, 2.0, 3.0)]);
        assert_eq!(centers(&lanes, 125.0)[..2], [(-3, -6.25, 1.5), (-2, -4.0, 3.0)]);
        assert_eq!(lanes.strip(10.0, -3), None);
        assert!(!lanes.is_uniform());
        let exit = lanes.center(1, 0);
        assert_eq!([0.0, 100.0, 125.0, 150.0].map(|s| exit.at(s)), [-5.5, -5.5, -6.25, -7.0]);
        assert_eq!([0.0, 99.0, 101.0].map(|s| lanes.center(0, 0).at(s)), [-4.0; 3]);
    }

    #[test]
    fn a_road_driven_from_its_end_has_the_same_lanes_on_the_other_side() {
        let (lanes, back) = (exit(), exit().reversed());
        for s_m in [10.0, 90.0, 110.0, 140.0] {
            let mut mirrored = centers(&lanes, s_m);
            mirrored.reverse();
            let turned: Vec<_> =
                centers(&back, 150.0 - s_m).into_iter().map(|(id, t, w)| (id, -t, w)).collect();
            for (a, b) in mirrored.iter().zip(&turned) {
                assert!(a.0 == b.0 && (a.1 - b.1).abs() < 1e-12 && (a.2 - b.2).abs() < 1e-12);
            }
            assert_eq!(mirrored.len(), turned.len());
        }
        assert_eq!(back.reversed().sections[0].lanes[2].after, Some(3));
    }

    #[test]
    fn roads_in_a_row_link_their_lanes() {
        let mut lanes = exit();
        lanes.append(&exit(), &[(1, 0), (2, 1), (3, 2)]);
        assert_eq!(lanes.length_m, 300.0);
        assert_eq!(centers(&lanes, 275.0), centers(&exit(), 125.0));
        let center = lanes.center(0, 1);
        assert_eq!([10.0, 120.0, 160.0, 290.0].map(|s| center.at(s)), [-1.0; 4]);
    }
}
