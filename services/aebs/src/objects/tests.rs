use super::*;

const PERIOD_NS: i64 = 50_000_000;
const HALF_FIELD_RAD: f64 = 0.52;

fn detection(x_m: f64, y_m: f64, relative_mps: f64) -> Detection {
    let azimuth_rad = libm::atan2(y_m, x_m);
    Detection {
        range_m: (x_m * x_m + y_m * y_m).sqrt(),
        range_rate_mps: relative_mps * libm::cos(azimuth_rad),
        azimuth_rad,
        snr_db: 25.0,
        rcs_dbsm: 10.0,
        flags: 0,
        ambiguity_group: 0,
    }
}

/// Scans a vehicle of five points whose rear is at `x(t)` and middle at `y(t)`.
fn follow(objects: &mut Objects, scans: i64, x: impl Fn(f64) -> f64, y: impl Fn(f64) -> f64) {
    let ego_mps = 20.0;
    for k in 0..scans {
        let t = k as f64 * 0.05;
        let relative_mps = (x(t + 1e-6) - x(t)) / 1e-6;
        let points = [(0.0, 0.0), (0.0, 0.9), (0.0, -0.9), (0.8, 0.9), (3.4, 0.9)];
        let list = points.map(|(dx, dy)| detection(x(t) + dx, y(t) + dy, relative_mps));
        objects.take_scan(&Way::default(), 1.0, k * PERIOD_NS, ego_mps, &list);
    }
}

#[test]
fn one_vehicle_of_many_points_is_one_object() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 20, |t| 40.0 - 5.0 * t, |_| 0.2);
    let list: Vec<_> = objects.confirmed().collect();
    assert_eq!(list.len(), 1, "{list:?}");
    let object = list[0];
    assert!((object.distance_m - (40.0 - 5.0 * 0.95)).abs() < 0.3, "{object:?}");
    assert!((object.speed_mps - 15.0).abs() < 0.1);
    assert!((object.lateral.position_m - 0.2).abs() < 0.3);
}

#[test]
fn three_scans_confirm_what_moves() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 2, |t| 40.0 - 5.0 * t, |_| 0.0);
    assert_eq!(objects.confirmed().count(), 0);
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 3, |t| 40.0 - 5.0 * t, |_| 0.0);
    assert_eq!(objects.confirmed().count(), 1);
}

#[test]
fn hard_braking_is_found_within_a_quarter_of_a_second() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    let x = |t: f64| 40.0 - if t > 1.0 { 4.5 * (t - 1.0) * (t - 1.0) } else { 0.0 };
    follow(&mut objects, 26, x, |_| 0.0);
    let object = objects.confirmed().next().expect("seen for a second");
    assert!(object.acceleration_mps2 < -4.5, "{object:?}");
}

#[test]
fn a_cut_in_shows_its_lateral_speed() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 30, |t| 25.0 - 5.0 * t, |t| 3.5 - 1.0 * t);
    let object = objects.confirmed().next().expect("seen for a second");
    assert!((object.lateral.rate_mps + 1.0).abs() < 0.2, "{object:?}");
}

#[test]
fn a_post_beside_the_road_is_not_an_object_and_a_vehicle_that_stands_ahead_is() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 10, |t| 80.0 - 20.0 * t, |_| 6.0);
    assert_eq!(objects.confirmed().count(), 0);
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 10, |t| 80.0 - 20.0 * t, |_| 0.3);
    assert!(objects.confirmed().next().is_some_and(Object::stands));
}

#[test]
fn scattered_false_alarms_become_nothing() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    for k in 0..20_000 {
        let scattered = detection(150.0 * random(), 20.0 * random() - 10.0, 60.0 * random() - 50.0);
        objects.take_scan(&Way::default(), 1.0, k * PERIOD_NS, 25.0, &[scattered]);
        assert_eq!(objects.confirmed().count(), 0, "scan {k}");
    }
}

#[test]
fn an_object_out_of_sight_is_kept_for_a_while_and_then_dropped() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    follow(&mut objects, 20, |t| 40.0 - 5.0 * t, |_| 0.0);
    for k in 20..28 {
        objects.take_scan(&Way::default(), 1.0, k * PERIOD_NS, 20.0, &[]);
        assert_eq!(objects.confirmed().count(), 1, "scan {k}");
    }
    objects.take_scan(&Way::default(), 1.0, 29 * PERIOD_NS, 20.0, &[]);
    assert_eq!(objects.confirmed().count(), 0);
}

#[test]
fn an_object_beside_the_ego_and_out_of_sight_is_carried_on() {
    // Its rear passes the edge of the field of view, then all of it does.
    let mut objects = Objects::new(HALF_FIELD_RAD);
    let x = |t: f64| 12.0 - 6.0 * t;
    for k in 0..80 {
        let t = k as f64 * 0.05;
        let places = [(0.0, 0.0), (0.0, 0.9), (0.0, -0.9), (0.9, -0.9), (3.4, -0.9)];
        let list: Vec<_> = places
            .map(|(dx, dy)| detection(x(t) + dx, 3.5 + dy, -6.0))
            .into_iter()
            .filter(|detection| detection.azimuth_rad.abs() < HALF_FIELD_RAD)
            .collect();
        objects.take_scan(&Way::default(), 1.0, k * PERIOD_NS, 20.0, &list);
        let kept = objects.confirmed().next();
        if k >= 3 && x(t) > -4.0 {
            let object = kept.unwrap_or_else(|| panic!("it is lost at {} m", x(t)));
            assert!((object.distance_m - x(t)).abs() < 0.6, "{} {object:?}", x(t));
            assert!((object.lateral.position_m - 3.5).abs() < 0.3, "{} {object:?}", x(t));
        }
    }
}

#[test]
fn a_long_vehicle_beside_the_path_stays_beside_it_along_all_of_its_side() {
    // A part farther along it than an object reaches becomes another object. All are 3.5 m off; taken for a face, a
    // place of the side would be 2.6 m off.
    let mut objects = Objects::new(HALF_FIELD_RAD);
    let mut worst_m = 3.5_f64;
    for k in 0..100 {
        let x_m = 90.0 - 1.2 * f64::from(k);
        let mut list = vec![detection(x_m, 3.5, -24.0)];
        // The places that reflect are not all seen in each scan.
        let side = (0..6).filter(|place| (place + k) % 4 != 0);
        let ahead =
            |detection: &Detection| detection.range_m > 0.5 && detection.azimuth_rad.abs() < 0.5;
        list.extend(side.map(|place| detection(x_m + 0.9 + 3.2 * f64::from(place), 2.6, -24.0)));
        list.retain(ahead);
        objects.take_scan(&Way::default(), 1.0, i64::from(k) * PERIOD_NS, 29.0, &list);
        let seen = objects.confirmed().filter(|object| k > 20 && object.unseen_s == 0.0);
        worst_m = seen.fold(worst_m, |worst, object| worst.min(object.lateral.position_m));
    }
    // A part that shows no face is taken for one of its side, 0.7 m clear of the path.
    assert!(worst_m > 2.5, "{worst_m}");
}

/// Echoes of the places of a car's rear that a car at `near` leaves free. That car hides the places from there on.
fn uncovered(x_m: f64, relative_mps: f64, near: (f64, f64)) -> Vec<Detection> {
    let edge_m = (near.1 - 0.95) / (near.0 + 4.3) * x_m;
    let free = [-0.95, 0.0, 0.95].into_iter().filter(|y_m| *y_m < edge_m);
    free.map(|y_m| detection(x_m, y_m, relative_mps)).collect()
}

#[test]
fn an_object_half_hidden_by_a_leaving_lead_is_in_the_path() {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    for k in 0..30 {
        let (time_s, x_m) = (f64::from(k) * 0.05, 90.0 - f64::from(k));
        // The lead is 0.4 m off the axis at first, and leaves with 0.5 m/s.
        let y_m = 0.4 + 0.5 * time_s;
        let places = [(0.0, -0.95), (0.0, 0.0), (0.0, 0.95)];
        let mut list: Vec<_> = places.map(|(dx, dy)| detection(40.0 + dx, y_m + dy, 0.0)).to_vec();
        list.extend(uncovered(x_m, -20.0, (40.0, y_m)));
        objects.take_scan(&Way::default(), 1.0, i64::from(k) * PERIOD_NS, 20.0, &list);
    }
    let object = objects.confirmed().find(|object| object.stands()).expect("it is seen");
    // Only its right corner and its middle were.
    assert!(object.lateral.position_m.abs() < 0.4, "{object:?}");
    let stands = objects.threats(3.0).filter(Object::stands).count();
    assert_eq!(stands, 2, "and the lead will stand before it");
}

#[test]
fn a_standing_queue_beside_the_lane_stays_there() {
    // Its points are on both sides of any limit that leaves out what stands beside the road.
    let mut objects = Objects::new(HALF_FIELD_RAD);
    for k in 0..40 {
        let x_m = 90.0 - f64::from(k);
        let noise_m = [0.5, -0.4, 0.3, -0.5, 0.1][k as usize % 5] * x_m / 90.0;
        let places = [(0.0, 2.6), (0.0, 3.5), (0.9, 2.6), (3.6, 2.6)];
        let list = places.map(|(dx, y_m)| detection(x_m + dx, y_m + noise_m, -20.0));
        objects.take_scan(&Way::default(), 1.0, i64::from(k) * PERIOD_NS, 20.0, &list);
    }
    let object = objects.confirmed().next().expect("it is followed");
    assert!((object.lateral.position_m - 3.5).abs() < 0.2, "{object:?}");
    assert!(object.lateral.rate_mps.abs() < 1e-6, "what stands does not move: {object:?}");
}

/// The scan in which a standing car counts of which every seventh scan shows something.
fn counts_from(share: f64) -> Option<i64> {
    let mut objects = Objects::new(HALF_FIELD_RAD);
    (0..80).find(|k| {
        let x_m = 90.0 - 0.4 * *k as f64;
        let list = [detection(x_m, 0.2, -8.0)];
        let seen = if k % 7 == 0 { &list[..] } else { &[] };
        objects.take_scan(&Way::default(), share, k * PERIOD_NS, 8.0, seen);
        objects.confirmed().next().is_some()
    })
}

#[test]
fn a_radar_that_shows_little_is_given_time() {
    assert_eq!(counts_from(1.0), None);
    assert_eq!(counts_from(0.15), Some(21), "four of 22 scans");
    assert_eq!(counts_from(0.0), Some(21));
}

/// Scan of what stands at places of the plane, and of a car on a circle. The ego that sees it has driven `way_m` along
/// another circle.
mod in_curves {
    use super::*;
    use crate::corridor::Corridor;

    const EGO_MPS: f64 = 20.0;

    /// Detection of a point of the body that moves with a heading, seen by an ego without slip.
    fn seen(x_m: f64, y_m: f64, speed_mps: f64, heading_rad: f64) -> Detection {
        let azimuth_rad = libm::atan2(y_m, x_m);
        Detection {
            range_rate_mps: speed_mps * libm::cos(azimuth_rad - heading_rad)
                - EGO_MPS * libm::cos(azimuth_rad),
            ..detection(x_m, y_m, 0.0)
        }
    }

    /// A drive on a circle of `radius_m`; `scan` lists what is seen at a time.
    fn drive(
        radius_m: f64,
        scans: i64,
        scan: impl Fn(f64, &Corridor) -> Vec<Detection>,
    ) -> (Objects, Way) {
        let (mut objects, mut way) = (Objects::new(HALF_FIELD_RAD), Way::new(0.0, 0.0));
        for k in 0..scans {
            way.take(k * PERIOD_NS, EGO_MPS / radius_m, EGO_MPS);
            way.look(k * PERIOD_NS, None, 0);
            let mut list = scan(k as f64 * 0.05, &way.corridor);
            list.sort_by(|a, b| a.range_m.total_cmp(&b.range_m));
            objects.take_scan(&way, 1.0, k * PERIOD_NS, EGO_MPS, &list);
        }
        (objects, way)
    }

    #[test]
    fn a_lead_of_a_curve_is_on_the_way_and_its_neighbour_beside_it() {
        for (radius_m, lane_m) in [(125.0, 0.0), (-125.0, 0.0), (250.0, 3.5), (-125.0, -3.5)] {
            let (objects, _) = drive(radius_m, 40, |time_s, circle| {
                let along_m = 60.0 - 5.0 * time_s;
                let places = [(0.0, 0.9), (0.0, -0.9), (0.0, 0.0)];
                let of_car = |(dx, dy): (f64, f64)| {
                    let (x_m, y_m) = circle.to_body(along_m + dx, lane_m + dy);
                    let speed_mps = EGO_MPS - 5.0;
                    seen(x_m, y_m, speed_mps, circle.heading_rad(along_m))
                };
                places.map(of_car).to_vec()
            });
            let list: Vec<_> = objects.confirmed().collect();
            let [object] = list[..] else { panic!("{radius_m}: {list:?}") };
            let expected_m = 60.0 - 5.0 * 1.95;
            assert!((object.distance_m - expected_m).abs() < 0.4, "{radius_m}: {object:?}");
            assert!((object.lateral.position_m - lane_m).abs() < 0.2, "{radius_m}: {object:?}");
            assert!((object.speed_mps - 15.0).abs() < 0.2, "{radius_m}: {object:?}");
            assert!(object.lateral.rate_mps.abs() < 0.1, "{radius_m}: {object:?}");
        }
    }

    #[test]
    fn a_standing_object_keeps_its_place_while_the_ego_steers_into_a_curve() {
        // The ego drives straight for 1 s, and then with a radius of 250 m. The steps are 1 ms, by dead reckoning.
        let (mut objects, mut way) = (Objects::new(HALF_FIELD_RAD), Way::new(0.0, 0.0));
        let (car_x_m, car_y_m) = (75.0, 4.0);
        let (mut x_m, mut y_m, mut heading_rad) = (0.0, 0.0, 0.0_f64);
        for k in 0..2000 {
            let yaw_rate_radps = if k < 1000 { 0.0 } else { EGO_MPS / 250.0 };
            if k % 10 == 0 {
                way.take(k * 1_000_000, yaw_rate_radps, EGO_MPS);
            }
            if k % 50 == 0 {
                let (sine, cosine) = libm::sincos(heading_rad);
                let (dx, dy) = (car_x_m - x_m, car_y_m - y_m);
                let (ahead_m, left_m) = (dx * cosine + dy * sine, dy * cosine - dx * sine);
                let list = [seen(ahead_m, left_m, 0.0, 0.0)];
                way.look(k * 1_000_000, None, 0);
                objects.take_scan(&way, 1.0, k * 1_000_000, EGO_MPS, &list);
                if k > 500 {
                    let object = objects.confirmed().next().expect("it is followed");
                    let (body_x_m, body_y_m) =
                        way.corridor.to_body(object.distance_m, object.lateral.position_m);
                    assert!((body_x_m - ahead_m).abs() < 0.3, "{k}: {object:?} {ahead_m}");
                    assert!((body_y_m - left_m).abs() < 0.3, "{k}: {object:?} {left_m}");
                    assert!(object.lateral.rate_mps.abs() < 1e-3, "{k}: {object:?}");
                }
            }
            heading_rad += 0.001 * yaw_rate_radps;
            let (sine, cosine) = libm::sincos(heading_rad);
            x_m += 0.001 * EGO_MPS * cosine;
            y_m += 0.001 * EGO_MPS * sine;
        }
    }

    /// A queue before a curve of 250 m that begins in 30 m: the places that stand in the corridor's lane.
    fn in_lane_before_a_curve(off_m: f64) -> Vec<f64> {
        let cells = std::array::from_fn(|cell| if cell < 3 { 0.0 } else { 1.0 / 250.0 });
        let mut objects = Objects::new(HALF_FIELD_RAD);
        let mut way = Way::new(0.0, 0.0);
        for k in 0..12 {
            let driven_m = EGO_MPS * 0.05 * k as f64;
            let road = Corridor::of_cells(&cells, driven_m, 0.0, 0.0);
            let mut course: messages::Course = bytemuck::Zeroable::zeroed();
            course.header.acquisition_ns = 0;
            course.curvatures_perm = cells;
            (course.sigma_50_m, course.sigma_100_m, course.valid_m) = (0.2, 0.5, 150.0);
            way.take(k * PERIOD_NS, 0.0, EGO_MPS);
            way.look(k * PERIOD_NS, Some(&course), i64::MAX);
            let places = (0..8).map(|car| 28.0 + 8.0 * f64::from(car) - driven_m);
            let places = places.map(|along_m| road.to_body(along_m, off_m));
            let list: Vec<_> = places.map(|(x_m, y_m)| seen(x_m, y_m, 0.0, 0.0)).collect();
            objects.take_scan(&way, 1.0, k * PERIOD_NS, EGO_MPS, &list);
        }
        let offs_m = objects.confirmed().map(|object| object.lateral.position_m);
        offs_m.filter(|off_m| off_m.abs() < 1.9).collect()
    }

    #[test]
    fn a_queue_beside_a_curve_ahead_is_beside_the_corridor_and_one_in_the_lane_is_in_it() {
        assert!(in_lane_before_a_curve(-3.5).is_empty());
        // Here the echo of a hidden car is still its middle. What is hidden shifts it by half a width at most.
        let in_lane = in_lane_before_a_curve(0.0);
        assert!(in_lane.len() == 8 && in_lane.iter().all(|off_m| off_m.abs() < 0.9), "{in_lane:?}");
    }

    #[test]
    fn on_a_straight_road_the_way_is_sure() {
        let mut objects = Objects::new(HALF_FIELD_RAD);
        follow(&mut objects, 20, |t| 60.0 - 20.0 * t, |_| 0.2);
        let object = objects.confirmed().next().expect("it stands");
        assert_eq!((object.bow_m, object.way_sigma_m), (0.0, 0.0));
    }
}
