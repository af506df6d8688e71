use super::*;
use crate::mentions::assert_mentions;

fn check(text: &str) -> Result<Checked, String> {
    let settings: Settings = toml::from_str(text).map_err(|error| error.to_string())?;
    settings.check(Path::new("field/robot.toml")).map_err(|error| error.to_string())
}

#[test]
fn omitted_qos_fields_have_the_defaults_of_ros() {
    let checked = check("transport = 'rmw_zenoh'\nnamespace = 'robot1'").unwrap();
    let received: Vec<String> =
        checked.subscriptions.iter().map(|subscription| subscription.topic.to_string()).collect();
    let status = "/robot1/navigate_to_pose/_action/status";
    assert_eq!(received, ["/robot1/odom", "/robot1/amcl_pose", "/robot1/fix", "/robot1/map", status]);
    let published: Vec<String> = checked.publications.values().map(TopicName::to_string).collect();
    let own = [
        "/robot1/goal_pose",
        "/robot1/dragnet/path",
        "/robot1/dragnet/belief",
        "/robot1/dragnet/objects",
        "/robot1/dragnet/tracks",
    ];
    assert_eq!(published[..5], own);
    assert_eq!(published[5..], ["/diagnostics"]);
    assert_eq!((checked.domain, checked.network.mode), (0, Mode::Client));
}

#[test]
fn topics_can_be_left_out_and_cameras_added() {
    let text = "transport = 'bridge'\nsubscribe = { fix = '', pose = '', map = '', goals = '' }\npublish = { goal = '/goal' }\n\
                zenoh.config = 'ros.json5'\n\
                cameras = [{ name = 'front', detections = 'front/seen', image = 'front/image_raw' }]";
    let checked = check(text).unwrap();
    let received: Vec<(InputKind, &str)> =
        checked.subscriptions.iter().map(|subscription| (subscription.kind, &*subscription.camera)).collect();
    let front = "front";
    assert_eq!(
        received,
        [(InputKind::Odometry, ""), (InputKind::Detections, front), (InputKind::Image, front)]
    );
    assert_eq!(checked.publications[&OutputKind::Goal].to_string(), "/goal");
    assert_eq!(checked.network.config, Some(PathBuf::from("field/ros.json5")));
}

#[test]
fn invalid_settings_are_reported_with_their_key() {
    let refused = |text: &str, reason: &str| {
        let error = check(&format!("transport = 'bridge'\n{text}")).unwrap_err();
        assert_mentions(&error, reason);
    };
    refused("domain = 233", "field/robot.toml .. ros.domain .. 233 .. 0 to 232");
    refused("topics = 1", "unknown .. `topics`");
    refused("subscribe.odom = 'odom'", "unknown .. `odom`");
    refused("subscribe.odometry = 'a b'", "ros.subscribe.odometry .. \"a b\"");
    refused("namespace = '1'", "ros.namespace .. \"1\"");
    refused("position_std_meters = 0", "position_std_meters .. 0 .. above 0, at most 1000");
    refused("heading_std_degrees = 91", "heading_std_degrees .. 91 .. above 0, at most 90");
    refused("localization_timeout_seconds = 0", "localization_timeout_seconds .. 0 .. above 0, at most 3600");
    refused("max_uncorrected_meters = nan", "ros.max_uncorrected_meters .. NaN");
    refused("map_frame = ''", "ros.map_frame .. empty");
    refused("publish.goal = 'odom'", "/odom .. twice");
    refused("zenoh.listen = ['tcp/127.0.0.1:7447']", "client .. one endpoint");
    refused("zenoh.connect = []", "client .. one endpoint");
    refused("cameras = [{ name = 'a' }]", "ros.cameras .. \"a\" .. no topic");
    refused("cameras = [{ name = 'a', image = 'x' }, { name = 'a', image = 'y' }]", "ros.cameras .. name");
}

#[test]
fn transforms_and_calibrations_are_subscribed_where_they_are_used() {
    let kinds = |text: &str| {
        let checked = check(&format!(
            "transport = 'bridge'\nsubscribe = {{ odometry = '', pose = '', fix = '', map = '', goals = '' }}\n{text}"
        ));
        checked.map(|checked| {
            let topics = checked.subscriptions.iter().map(|one| format!("{:?} {}", one.kind, one.topic));
            topics.collect::<Vec<_>>()
        })
    };
    let tf = ["Transforms /tf", "StaticTransforms /tf_static"];
    assert_eq!(kinds("localization = 'tf'").unwrap(), tf);
    let by_hand = "cameras = [{ name = 'a', detections = 'seen' }]";
    assert_eq!(kinds(by_hand).unwrap(), ["Detections /seen"]);
    let mounted = "cameras = [{ name = 'a', detections = 'seen', mounting = 'tf' }]";
    assert_eq!(kinds(mounted).unwrap(), [tf[0], tf[1], "Detections /seen"]);
    let both = "cameras = [{ name = 'a', detections = 'seen', camera_info = 'info' }]";
    assert_eq!(kinds(both).unwrap(), [tf[0], tf[1], "Detections /seen", "CameraInfo /info"]);
    let optics =
        "cameras = [{ name = 'a', detections = 'seen', camera_info = 'info', mounting = 'settings' }]";
    assert_eq!(kinds(optics).unwrap(), ["Detections /seen", "CameraInfo /info"]);
    let supply = "emergency_stop = { topic = 'stop' }\nbattery = { topic = 'charge' }";
    assert_eq!(kinds(supply).unwrap(), ["Stop /stop", "Battery /charge"]);

    let refused = |text: &str, reason: &str| {
        assert_mentions(&check(&format!("transport = 'bridge'\n{text}")).unwrap_err(), reason);
    };
    refused("localization = 'tf'\nsubscribe.tf = ''", "ros.subscribe.tf is empty");
    refused("robot_frame = ''", "ros.robot_frame is empty");
    refused("cameras = [{ name = 'a', camera_info = 'info' }]", "\"a\" has no topic");
    refused("emergency_stop = { topic = 'stop', timeout_seconds = 0 }", "timeout_seconds is 0 .. above 0");
    refused("battery = { topic = 'charge', min_percent = 101 }", "min_percent is 101 .. 0 to 100");
}
