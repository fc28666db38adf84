//! Our world against a small interpreter of the standard that shares no code with it.
//!
//! It has a reader of its own, and adds up steps of 0.1 ms in place of closed forms. It knows lane positions on a straight
//! road, changes of speed and lane, clothoids, and conditions on time, distance, way and the storyboard. Of a net it knows
//! lines and arcs, the lane -1, and the ways through a junction.

mod common;

use std::f64::consts::PI;

use common::*;

/// Largest difference of a place, m.
const WITHIN_M: f64 = 0.01;
/// Steps of the interpreter in a step of the world.
const PARTS: u32 = 100;

struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
    inside: Vec<Tag>,
}

impl Tag {
    /// The elements of a text without comments and texts.
    fn parse(text: &str) -> Tag {
        let mut open =
            vec![Tag { name: String::new(), attributes: Vec::new(), inside: Vec::new() }];
        for piece in text.split('<').skip(1) {
            let (head, _) = piece.split_once('>').expect("a tag ends");
            if head.starts_with('/') {
                let done = open.pop().expect("it was opened");
                open.last_mut().expect("a root").inside.push(done);
                continue;
            }
            let name = head.split([' ', '/']).next().expect("a name").to_owned();
            let parts: Vec<&str> = head[name.len()..].split('"').collect();
            let pairs = parts.chunks(2).filter(|pair| pair.len() == 2);
            let attributes = pairs
                .map(|pair| (pair[0].trim().trim_end_matches('=').to_owned(), pair[1].to_owned()));
            let tag = Tag { name, attributes: attributes.collect(), inside: Vec::new() };
            match head.ends_with('/') {
                true => open.last_mut().expect("a root").inside.push(tag),
                false => open.push(tag),
            }
        }
        open.pop().expect("a root")
    }

    /// All elements of a name, in order.
    fn all<'a>(&'a self, name: &str) -> Vec<&'a Tag> {
        let inside = self.inside.iter().flat_map(|tag| tag.all(name));
        let own = (self.name == name).then_some(self);
        own.into_iter().chain(inside).collect()
    }

    fn one(&self, name: &str) -> Option<&Tag> {
        self.all(name).first().copied()
    }

    fn text(&self, name: &str) -> &str {
        let found = self.attributes.iter().find(|(key, _)| key == name);
        found.map_or("", |(_, value)| value.as_str())
    }

    fn number(&self, name: &str) -> f64 {
        self.text(name).parse().unwrap_or(0.0)
    }
}

/// A quantity on its way from one value to another.
#[derive(Clone, Copy)]
struct Change {
    from: f64,
    to: f64,
    begin_s: f64,
    takes_s: f64,
    shape: fn(f64) -> f64,
}

impl Change {
    fn of(dynamics: &Tag, from: f64, to: f64, begin_s: f64) -> Self {
        let (shape, steepest): (fn(f64) -> f64, f64) = match dynamics.text("dynamicsShape") {
            "sinusoidal" => (|x| (1.0 - (PI * x).cos()) / 2.0, PI / 2.0),
            "cubic" => (|x| x * x * (3.0 - 2.0 * x), 1.5),
            "linear" => (|x| x, 1.0),
            _ => (|_| 1.0, 0.0),
        };
        let value = dynamics.number("value");
        let takes_s = match dynamics.text("dynamicsDimension") {
            "rate" => steepest * (to - from).abs() / value,
            _ => value,
        };
        Self { from, to, begin_s, takes_s, shape }
    }

    fn at(&self, time_s: f64) -> f64 {
        let passed_s = time_s - self.begin_s;
        let x = if self.takes_s > 0.0 { (passed_s / self.takes_s).clamp(0.0, 1.0) } else { 1.0 };
        self.from + (self.to - self.from) * (self.shape)(x)
    }

    fn is_over(&self, time_s: f64) -> bool {
        time_s - self.begin_s >= self.takes_s - 1e-9
    }
}

#[derive(Default)]
struct Car {
    name: String,
    x: f64,
    y: f64,
    way: f64,
    mps: f64,
    speed: Option<(usize, Change)>,
    side: Option<(usize, Change)>,
    /// Clothoid: heading, curvature, its rate, the way that is left.
    curve: Option<(usize, [f64; 4])>,
    /// In a net: its road, the place along that, and the roads of its route.
    road: String,
    s: f64,
    over: Vec<String>,
}

/// The roads of a file.
#[derive(Clone, Copy)]
struct Net<'a>(&'a Tag);

impl<'a> Net<'a> {
    fn road(self, id: &str) -> &'a Tag {
        let road = self.0.all("road").into_iter().find(|road| road.text("id") == id);
        road.expect("it is there")
    }

    /// The curvature of a road, and the middle of its lane -1.
    fn lane(self, id: &str) -> (f64, f64) {
        let road = self.road(id);
        let offset = road.one("laneOffset").map_or(0.0, |tag| tag.number("a"));
        (road.one("arc").map_or(0.0, |arc| arc.number("curvature")), offset - 2.0)
    }

    fn at(self, id: &str, s: f64, t: f64) -> (f64, f64) {
        let line = self.road(id).one("geometry").expect("a line");
        let (curvature, _) = self.lane(id);
        let [x, y, from] = ["x", "y", "hdg"].map(|name| line.number(name));
        let heading = from + curvature * s;
        let (along, aside) = match curvature == 0.0 {
            true => (s * from.cos(), s * from.sin()),
            false => {
                ((heading.sin() - from.sin()) / curvature, (from.cos() - heading.cos()) / curvature)
            }
        };
        (x + along - t * heading.sin(), y + aside + t * heading.cos())
    }

    fn next(self, id: &str, over: &[String]) -> String {
        let link = self.road(id).one("successor").expect("a road behind it");
        if link.text("elementType") == "road" {
            return link.text("elementId").to_owned();
        }
        let ways = self.0.all("connection");
        let ways = ways.iter().filter(|way| way.text("incomingRoad") == id);
        let mut ways: Vec<&str> = ways.map(|way| way.text("connectingRoad")).collect();
        let turn = |id: &str| (self.lane(id).0 * self.road(id).number("length")).abs();
        ways.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
        let leads = |way: &&str| over.contains(&self.next(way, &[]));
        ways.iter().copied().find(leads).unwrap_or(ways[0]).to_owned()
    }
}

/// An event: 0 waits, 1 runs, 2 is complete.
struct Event<'a> {
    tag: &'a Tag,
    actor: String,
    state: u8,
    /// Time of the edge of its condition, s, and its last outcome.
    edge_s: Option<f64>,
    last: Option<bool>,
}

struct Interpreter<'a> {
    net: Option<Net<'a>>,
    cars: Vec<Car>,
    events: Vec<Event<'a>>,
    time_s: f64,
}

/// The middle of a lane of [`ROAD`], whose lanes are 4 m wide.
fn middle(lane: f64) -> f64 {
    4.0 * lane - 2.0 * lane.signum()
}

impl<'a> Interpreter<'a> {
    fn of(root: &'a Tag) -> Self {
        let mut cars = Vec::new();
        for private in root.all("Private") {
            let place = private.one("LanePosition").expect("a lane position");
            let (x, y) = (place.number("s"), middle(place.number("laneId")));
            let speed = private.one("AbsoluteTargetSpeed").map_or(0.0, |tag| tag.number("value"));
            let name = private.text("entityRef").to_owned();
            let waypoints =
                private.all("Waypoint").into_iter().filter_map(|tag| tag.one("LanePosition"));
            let over = waypoints.map(|tag| tag.text("roadId").to_owned()).collect();
            let (road, s) = (place.text("roadId").to_owned(), x);
            cars.push(Car { name, x, y, mps: speed, road, s, over, ..Car::default() });
        }
        let mut events = Vec::new();
        for group in root.all("ManeuverGroup") {
            let actor = group.one("Actors").and_then(|actors| actors.one("EntityRef"));
            let actor = actor.expect("an actor").text("entityRef");
            for tag in group.all("Event") {
                let actor = actor.to_owned();
                events.push(Event { tag, actor, state: 0, edge_s: None, last: None });
            }
        }
        Self { net: None, cars, events, time_s: 0.0 }
    }

    fn car(&self, name: &str) -> &Car {
        self.cars.iter().find(|car| car.name == name).expect("it is there")
    }

    /// Moves all to the next step of the world.
    fn advance(&mut self) {
        let dt = STEP_S / f64::from(PARTS);
        for part in 0..PARTS {
            let middle_s = self.time_s + (f64::from(part) + 0.5) * dt;
            for car in &mut self.cars {
                let mps = car.speed.map_or(car.mps, |(_, change)| change.at(middle_s));
                car.way += mps * dt;
                if let Some(net) = self.net {
                    let (curvature, t) = net.lane(&car.road);
                    car.s += mps * dt / (1.0 - curvature * t);
                    let length = net.road(&car.road).number("length");
                    if car.s > length {
                        (car.s, car.road) = (car.s - length, net.next(&car.road, &car.over));
                    }
                }
                match &mut car.curve {
                    None => car.x += mps * dt,
                    Some((_, [heading, curvature, rate, left])) => {
                        *heading += (*curvature + 0.5 * *rate * mps * dt) * mps * dt;
                        *curvature += *rate * mps * dt;
                        (car.x, car.y) =
                            (car.x + mps * dt * heading.cos(), car.y + mps * dt * heading.sin());
                        *left -= mps * dt;
                    }
                }
            }
        }
        self.time_s += STEP_S;
        for car in &mut self.cars {
            for (part, is_speed) in [(&mut car.speed, true), (&mut car.side, false)] {
                let Some((event, change)) = *part else { continue };
                *(if is_speed { &mut car.mps } else { &mut car.y }) = change.at(self.time_s);
                if change.is_over(self.time_s) {
                    (self.events[event].state, *part) = (2, None);
                }
            }
            if let Some((event, [.., left])) = car.curve
                && left <= 0.0
            {
                (self.events[event].state, car.curve) = (2, None);
            }
        }
    }

    /// Starts events until nothing starts.
    fn storyboard(&mut self) {
        let mut again = true;
        while std::mem::take(&mut again) {
            for number in 0..self.events.len() {
                if self.events[number].state == 0 && self.is_due(number) {
                    self.start(number);
                    again = true;
                }
            }
        }
    }

    fn is_due(&mut self, number: usize) -> bool {
        let tag = self.events[number].tag;
        let condition = tag.one("Condition").expect("a condition");
        let holds = self.holds(condition);
        let event = &mut self.events[number];
        let rises = event.last.replace(holds) == Some(false) && holds;
        match condition.text("conditionEdge") {
            "rising" if rises => event.edge_s = Some(self.time_s),
            "none" if holds => event.edge_s = event.edge_s.or(Some(self.time_s)),
            _ => {}
        }
        let delay_s = condition.number("delay");
        event.edge_s.is_some_and(|edge_s| self.time_s - edge_s >= delay_s - 1e-9)
    }

    fn holds(&self, condition: &Tag) -> bool {
        let entity = condition.one("EntityRef").map_or("", |tag| tag.text("entityRef"));
        if let Some(time) = condition.one("SimulationTimeCondition") {
            return self.time_s >= time.number("value") - 1e-9;
        }
        if let Some(state) = condition.one("StoryboardElementStateCondition") {
            let name = state.text("storyboardElementRef");
            let mut found = self.events.iter().filter(|event| event.tag.text("name") == name);
            return found.any(|event| event.state == 2);
        }
        if let Some(way) = condition.one("TraveledDistanceCondition") {
            return self.car(entity).way >= way.number("value");
        }
        let apart = condition.one("RelativeDistanceCondition").expect("a known condition");
        let other = self.car(apart.text("entityRef"));
        (other.x - self.car(entity).x).abs() < apart.number("value")
    }

    fn start(&mut self, number: usize) {
        let (tag, now_s) = (self.events[number].tag, self.time_s);
        let name = self.events[number].actor.clone();
        let beside = tag.one("RelativeTargetLane").map(|tag| self.car(tag.text("entityRef")).y);
        let index = self.cars.iter().position(|car| car.name == name).expect("it is there");
        self.events[number].state = 1;
        let car = &mut self.cars[index];
        if let Some(target) = tag.one("AbsoluteTargetSpeed") {
            let dynamics = tag.one("SpeedActionDynamics").expect("dynamics");
            let change = Change::of(dynamics, car.mps, target.number("value"), now_s);
            car.speed = Some((number, change));
        } else if let Some(curve) = tag.one("Clothoid") {
            let rate = curve.number("curvaturePrime");
            car.curve =
                Some((number, [0.0, curve.number("curvature"), rate, curve.number("length")]));
        } else {
            let lane = tag.one("AbsoluteTargetLane").map(|tag| middle(tag.number("value")));
            let goal = lane.or(beside).expect("a lane");
            let dynamics = tag.one("LaneChangeActionDynamics").expect("dynamics");
            car.side = Some((number, Change::of(dynamics, car.y, goal, now_s)));
        }
    }
}

/// Runs both for a time, and compares all places in each step.
fn compare(events: &[String], until_s: f64) {
    let parts = Parts { stories: story(events), ..Parts::default() };
    let text = parts.text();
    let root = Tag::parse(&text);
    let (mut ours, mut other) = (parts.run(), Interpreter::of(&root));
    for step in 0..(until_s / STEP_S) as u32 {
        if step > 0 {
            other.advance();
        }
        other.storyboard();
        let time_s = f64::from(step) * STEP_S;
        let lead = ours.to(time_s).lead();
        let car = other.car("Lead");
        let (ds, dt) = (lead.s_m - car.x, lead.t_m - car.y);
        assert!(ds.hypot(dt) < WITHIN_M, "{ds} m along, {dt} m across at {time_s} s");
    }
}

#[test]
fn speeds_and_lanes_change_alike() {
    let lane = |id: i32| format!("<AbsoluteTargetLane value=\"{id}\"/>");
    let passed = |way_m: f64| {
        by_entity("rising", 0.5, "Lead", &format!("<TraveledDistanceCondition value=\"{way_m}\"/>"))
    };
    let near = "<RelativeDistanceCondition entityRef=\"Lead\" relativeDistanceType=\"longitudinal\" coordinateSystem=\"road\" \
                value=\"30\" freespace=\"false\" rule=\"lessThan\"/>";
    let done = |name: &str, delay_s: f64| state("none", delay_s, "event", name, "completeState");
    let event = |name: &str, action: &str, condition: &str| {
        event(name, "parallel", &[action], &trigger(&[condition]))
    };
    compare(
        &[
            event("slow", &speed("sinusoidal", "rate", 2.0, 12.0), &at(1.0)),
            event("left", &lane_change("cubic", "time", 3.0, &lane(1)), &passed(40.0)),
            event("back", &lane_change("sinusoidal", "rate", 1.2, &lane(-2)), &done("left", 1.0)),
            event(
                "fast",
                &speed("cubic", "time", 4.0, 25.0),
                &by_entity("rising", 0.0, "Ego", near),
            ),
            event("stop", &speed("linear", "rate", 4.0, 0.0), &done("fast", 0.7)),
            event("again", &speed("step", "time", 0.0, 5.0), &done("stop", 0.0)),
        ],
        30.0,
    );
}

#[test]
fn a_clothoid_is_followed_alike() {
    let place = "<Position><LanePosition roadId=\"0\" laneId=\"-1\" s=\"80\"/></Position>";
    let shape = format!(
        "<Clothoid curvature=\"0.008\" curvaturePrime=\"-0.0003\" length=\"70\">{place}</Clothoid>"
    );
    let follow = format!(
        "<RoutingAction><FollowTrajectoryAction><TrajectoryRef><Trajectory name=\"t\" closed=\"false\"><Shape>{shape}</Shape></Trajectory></TrajectoryRef>\
         <TimeReference><None/></TimeReference><TrajectoryFollowingMode followingMode=\"follow\"/></FollowTrajectoryAction></RoutingAction>"
    );
    // It is at the line's start then.
    compare(&[event("E", "parallel", &[&follow], &trigger(&[&at(1.0)]))], 4.4);
}

#[test]
fn ways_through_a_junction_are_driven_alike() {
    let route = "<RoutingAction><AssignRouteAction><Route name=\"r\" closed=\"false\">\
                 <Waypoint routeStrategy=\"shortest\"><Position><LanePosition roadId=\"3\" laneId=\"-1\" s=\"90\"/></Position></Waypoint>\
                 <Waypoint routeStrategy=\"shortest\"><Position><LanePosition roadId=\"2\" laneId=\"-1\" s=\"90\"/></Position></Waypoint>\
                 </Route></AssignRouteAction></RoutingAction>";
    let place = teleport("<LanePosition roadId=\"3\" laneId=\"-1\" s=\"80\"/>");
    let cruise = speed("step", "time", 0.0, 14.0);
    let passed = "<TraveledDistanceCondition value=\"60\"/>";
    let events = [
        event("E", "parallel", &[&speed("sinusoidal", "rate", 1.5, 8.0)], &trigger(&[&at(2.0)])),
        event(
            "F",
            "parallel",
            &[&speed("cubic", "time", 3.0, 16.0)],
            &trigger(&[&by_entity("rising", 0.5, "Lead", passed)]),
        ),
    ];
    let net = crossing::net();
    let roads = Tag::parse(&net);
    for actions in [vec![&*place, &cruise], vec![&*place, &cruise, route]] {
        let (init, stories) = (private("Lead", &actions), story(&events));
        let files = vec![("dir/road.xodr".to_owned(), net.clone())];
        let parts = Parts { init, stories, files, ..Parts::default() };
        let text = parts.text();
        let root = Tag::parse(&text);
        let (mut ours, mut other) = (parts.run(), Interpreter::of(&root));
        other.net = Some(Net(&roads));
        for step in 0..2000 {
            if step > 0 {
                other.advance();
            }
            other.storyboard();
            let lead = ours.to(f64::from(step) * STEP_S).lead();
            let part = ours.world.script().roads[lead.row].part_at(lead.s_m);
            let ((s_m, t_m), car) = (part.own(lead.s_m, lead.t_m), other.car("Lead"));
            let (own, theirs) = (
                Net(&roads).at(&part.id, s_m, t_m),
                Net(&roads).at(&car.road, car.s, Net(&roads).lane(&car.road).1),
            );
            let away_m = (own.0 - theirs.0).hypot(own.1 - theirs.1);
            assert!(away_m < WITHIN_M, "{away_m} m in step {step}: road {} {}", part.id, car.road);
        }
        assert_eq!(other.car("Lead").road, if actions.len() > 2 { "2" } else { "4" });
    }
}
