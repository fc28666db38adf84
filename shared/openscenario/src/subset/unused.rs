//! Elements that are known and have no effect.

use super::body::BoundingBox;
use crate::declare::unused;

unused! { "Read, without effect";
    License ["name?" "resource?" "spdxId?"] {};
    SceneGraphFile ["filepath"] {};
    Properties [] {Vec<Property>, Vec<File>};
    Property ["name" "value"] {};
    File ["filepath"] {};
    Performance
        ["maxSpeed" "maxAcceleration" "maxDeceleration" "maxAccelerationRate?" "maxDecelerationRate?"]
        {};
    Axles [] {Option<FrontAxle>, RearAxle, Vec<AdditionalAxle>};
    FrontAxle | RearAxle | AdditionalAxle
        ["maxSteering" "wheelDiameter" "trackWidth" "positionX" "positionZ"] {};
    TrailerHitch | TrailerCoupler ["dx" "dz?"] {};
    TimeOfDay ["animation" "dateTime"] {};
    Weather ["cloudState?" "fractionalCloudCover?" "atmosphericPressure?" "temperature?"]
        {Option<Sun>, Option<Fog>, Option<Precipitation>, Option<Wind>, Option<DomeImage>};
    Sun ["azimuth" "elevation" "intensity?" "illuminance?"] {};
    Fog ["visualRange"] {Option<BoundingBox>};
    Precipitation ["precipitationType" "intensity?" "precipitationIntensity?"] {};
    Wind ["direction" "speed"] {};
    DomeImage ["azimuthOffset?"] {DomeFile};
    DomeFile ["filepath"] {};
}
