//! The publisher of a topic.

use std::time::Duration;

use dragnet_ros2::qos::{Durability, Qos};
use dragnet_ros2::rmw_zenoh::Attachments;
use zenoh::Session;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::qos::CongestionControl;
use zenoh_ext::{AdvancedPublisher, AdvancedPublisherBuilderExt, CacheConfig, MissDetectionConfig};

use crate::RuntimeError;

/// Period in which a latched publisher announces its sequence number: that of `rmw_zenoh`.
const HEARTBEAT: Duration = Duration::from_millis(500);

/// A publisher of one key.
pub(super) struct TopicPublisher {
    publisher: Kind,
    /// The attachments that `rmw_zenoh` requires; `None` behind a bridge.
    attachments: Option<Attachments>,
}

enum Kind {
    Plain(Publisher<'static>),
    /// Late subscribers receive the last messages.
    Latched(Box<AdvancedPublisher<'static>>),
}

impl TopicPublisher {
    pub(super) async fn declare(
        session: &Session,
        key: String,
        qos: Qos,
        attachments: Option<Attachments>,
    ) -> Result<Self, RuntimeError> {
        let what = format!("publish under {key}");
        // A latched message need not block its publisher: it is sent again.
        let congestion = match qos.durability {
            Durability::Volatile => CongestionControl::Block,
            Durability::TransientLocal => CongestionControl::Drop,
        };
        let publisher = session.declare_publisher(key).congestion_control(congestion).express(true);
        let publisher = match qos.durability {
            Durability::Volatile => publisher.await.map(Kind::Plain),
            Durability::TransientLocal => publisher
                .advanced()
                .publisher_detection()
                .cache(CacheConfig::default().max_samples(qos.depth))
                .sample_miss_detection(MissDetectionConfig::default().sporadic_heartbeat(HEARTBEAT))
                .await
                .map(|publisher| Kind::Latched(Box::new(publisher))),
        };
        Ok(Self { publisher: publisher.map_err(RuntimeError::zenoh(what))?, attachments })
    }

    pub(super) async fn has_subscribers(&self) -> Result<bool, RuntimeError> {
        let status = match &self.publisher {
            Kind::Plain(publisher) => publisher.matching_status().await,
            Kind::Latched(publisher) => publisher.matching_status().await,
        };
        Ok(status.map_err(RuntimeError::zenoh("ask who listens"))?.matching())
    }

    pub(super) async fn publish(&mut self, unix_ns: i64, bytes: Vec<u8>) -> Result<(), RuntimeError> {
        let attachment = self.attachments.as_mut().map(|attachments| ZBytes::from(attachments.next(unix_ns)));
        let published = match &self.publisher {
            Kind::Plain(publisher) => publisher.put(bytes).attachment(attachment).await,
            Kind::Latched(publisher) => publisher.put(bytes).attachment(attachment).await,
        };
        published.map_err(RuntimeError::zenoh("publish on the robot's own network"))
    }
}
