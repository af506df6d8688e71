//! The node: subscribers, which return checked messages, and publishers.

use std::collections::BTreeMap;
use std::sync::Arc;

use dragnet_ros2::bridge;
use dragnet_ros2::input::InputKind;
use dragnet_ros2::name::TopicName;
use dragnet_ros2::output::{Output, OutputKind};
use dragnet_ros2::qos::Durability;
use dragnet_ros2::rmw_zenoh::{self, Attachments, Publisher, Role};
use dragnet_ros2::schema::MessageType;
use zenoh::Session;
use zenoh::liveliness::LivelinessToken;
use zenoh::sample::{Sample, SampleKind};
use zenoh_ext::{AdvancedSubscriberBuilderExt, HistoryConfig, RecoveryConfig};

use super::inbox::{Arrived, Inbox, What};
use super::incoming::Incoming;
use super::publisher::TopicPublisher;
use super::session;
use super::settings::{Checked, Subscription, Transport};
use crate::RuntimeError;

/// A node of a robot's ROS 2 network.
pub struct Node {
    session: Session,
    settings: Checked,
    inbox: Arc<Inbox>,
    publishers: BTreeMap<OutputKind, TopicPublisher>,
    /// Liveliness tokens of the node and its topics.
    tokens: Vec<LivelinessToken>,
}

impl Node {
    /// Joins a network. It waits until a router or a bridge answers; dropping the future cancels that.
    ///
    /// # Errors
    /// If the settings are not Zenoh's, or Zenoh fails.
    pub async fn open(settings: Checked) -> Result<Self, RuntimeError> {
        let session = session::open(&settings.network).await?;
        let depths =
            settings.subscriptions.iter().map(|subscription| subscription.kind.qos().depth).collect();
        let mut node = Self {
            session,
            settings,
            inbox: Arc::new(Inbox::new(depths)),
            publishers: BTreeMap::new(),
            tokens: Vec::new(),
        };
        let me = node.me();
        node.announce(me.token()).await?;
        for (number, subscription) in node.settings.subscriptions.clone().into_iter().enumerate() {
            let message = subscription.kind.message();
            node.subscribe(number, &subscription, &message).await?;
            if node.settings.transport == Transport::RmwZenoh {
                node.watch(number, &subscription.topic, message.clone()).await?;
            }
            let qos = subscription.kind.qos();
            let entity = number + 1;
            let token = me.topic_token(entity, Role::Subscription, &subscription.topic, &message, qos);
            node.announce(token).await?;
        }
        let first = node.settings.subscriptions.len() + 1;
        for (entity, (kind, topic)) in (first..).zip(node.settings.publications.clone()) {
            let message = kind.message();
            let token = me.topic_token(entity, Role::Publisher, &topic, &message, kind.qos());
            let attachments = match node.settings.transport {
                Transport::RmwZenoh => Some(Attachments::of(&token)),
                Transport::Bridge => None,
            };
            let key = node.key(&topic, &message);
            let publisher = TopicPublisher::declare(&node.session, key, kind.qos(), attachments).await?;
            node.publishers.insert(kind, publisher);
            node.announce(token).await?;
        }
        Ok(node)
    }

    /// The next message. Cancel safe.
    pub async fn receive(&self) -> Incoming {
        self.receive_on().await.1
    }

    /// The next message, and its topic.
    pub async fn receive_on(&self) -> (TopicName, Incoming) {
        let Arrived { topic, what } = self.inbox.take().await;
        let subscription = &self.settings.subscriptions[topic];
        let received = match what {
            What::Rejected(reason) => Incoming::Rejected { topic: subscription.topic.clone(), reason },
            What::Message(bytes) => self.settings.understand(subscription, &bytes.to_bytes()),
        };
        (subscription.topic.clone(), received)
    }

    /// Publishes a message that is stamped with a Unix time, nanoseconds. Does nothing if the settings have no topic
    /// for it.
    ///
    /// # Errors
    /// If Zenoh fails.
    pub async fn publish(&mut self, unix_ns: i64, output: Output) -> Result<(), RuntimeError> {
        let Some(publisher) = self.publishers.get_mut(&output.kind()) else { return Ok(()) };
        publisher.publish(unix_ns, output.encode(&self.settings.map_frame, unix_ns)).await
    }

    /// Whether a topic has a subscriber; a goal that is published without one is lost.
    ///
    /// # Errors
    /// If Zenoh fails.
    pub async fn has_subscriber(&self, kind: OutputKind) -> Result<bool, RuntimeError> {
        match self.publishers.get(&kind) {
            Some(publisher) => publisher.has_subscribers().await,
            None => Ok(false),
        }
    }

    /// Number of routers, bridges and peers that this node is connected to now.
    pub async fn neighbors(&self) -> usize {
        let info = self.session.info();
        info.routers_zid().await.count() + info.peers_zid().await.count()
    }

    /// The subscribed topics.
    pub fn topics(&self) -> impl Iterator<Item = &TopicName> {
        self.settings.subscriptions.iter().map(|subscription| &subscription.topic)
    }

    fn me(&self) -> rmw_zenoh::Node {
        rmw_zenoh::Node {
            domain: self.settings.domain,
            session: self.session.zid().to_string(),
            namespace: self.settings.namespace.clone(),
            name: self.settings.node.clone(),
        }
    }

    fn key(&self, topic: &TopicName, message: &MessageType) -> String {
        match self.settings.transport {
            Transport::RmwZenoh => rmw_zenoh::data_key(self.settings.domain, topic, message),
            Transport::Bridge => bridge::data_key(topic),
        }
    }

    /// Declares a liveliness token for nodes of `rmw_zenoh`. A bridge needs none.
    async fn announce(&mut self, token: String) -> Result<(), RuntimeError> {
        if self.settings.transport == Transport::RmwZenoh {
            let token = self.session.liveliness().declare_token(token).await;
            self.tokens.push(token.map_err(RuntimeError::zenoh("say what the node does"))?);
        }
        Ok(())
    }

    async fn subscribe(
        &self,
        number: usize,
        subscription: &Subscription,
        message: &MessageType,
    ) -> Result<(), RuntimeError> {
        let (kind, inbox) = (subscription.kind, Arc::clone(&self.inbox));
        let key = self.key(&subscription.topic, message);
        let what = format!("subscribe to {key}");
        let received = move |sample: Sample| {
            if sample.kind() == SampleKind::Put {
                inbox.put(Arrived { topic: number, what: arrived(kind, &sample) });
            }
        };
        let subscriber = self.session.declare_subscriber(key).callback(received);
        let declared = match kind.qos().durability {
            Durability::Volatile => subscriber.background().await,
            Durability::TransientLocal => {
                subscriber
                    .advanced()
                    .history(HistoryConfig::default().detect_late_publishers().max_samples(kind.qos().depth))
                    .recovery(RecoveryConfig::default().heartbeat())
                    .subscriber_detection()
                    .background()
                    .await
            }
        };
        declared.map_err(RuntimeError::zenoh(what))
    }

    /// Reports publishers that cannot be received because their type differs.
    async fn watch(
        &self,
        number: usize,
        topic: &TopicName,
        expected: MessageType,
    ) -> Result<(), RuntimeError> {
        let inbox = Arc::clone(&self.inbox);
        self.session
            .liveliness()
            .declare_subscriber(rmw_zenoh::publishers(self.settings.domain, topic))
            .history(true)
            .callback(move |sample| {
                let publisher = match sample.kind() {
                    SampleKind::Put => Publisher::from_token(sample.key_expr().as_str()),
                    SampleKind::Delete => None,
                };
                if let Some(reason) = publisher.and_then(|publisher| publisher.mismatch(&expected)) {
                    inbox.put(Arrived { topic: number, what: What::Rejected(reason) });
                }
            })
            .background()
            .await
            .map_err(RuntimeError::zenoh("watch who publishes what"))
    }
}

/// Messages that are too long are dropped at once.
fn arrived(kind: InputKind, sample: &Sample) -> What {
    match kind.check_length(sample.payload().len()) {
        Ok(()) => What::Message(sample.payload().clone()),
        Err(error) => What::Rejected(error.to_string()),
    }
}
