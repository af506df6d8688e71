//! Pending handshakes, the oldest first: bounded in number, in total and by address.
//!
//! When full, the oldest is dropped. An honest client completes its handshake at once, so it is hardly ever the oldest,
//! even from the address of a flood.

use std::net::{IpAddr, Ipv6Addr};

/// Maximum number of pending handshakes.
pub(crate) const MOST: usize = 256;
/// Maximum number from one address, or from one network of IPv6.
pub(crate) const MOST_FROM_ONE: usize = 64;

/// The origin of each, and a handle to end it.
#[derive(Debug)]
pub(crate) struct Pending<T>(Vec<(IpAddr, T)>);

impl<T> Default for Pending<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> Pending<T> {
    /// Adds one; returns the one that has to make room for it.
    pub(crate) fn enter(&mut self, from: IpAddr, connection: T) -> Option<T> {
        let mut of_one = self.0.iter().enumerate().filter(|(_, (other, _))| *other == from);
        let oldest_of_one = of_one.next().map(|(place, _)| place);
        let is_crowd = 1 + of_one.count() >= MOST_FROM_ONE;
        let leaves = match oldest_of_one {
            Some(oldest) if is_crowd => Some(oldest),
            _ if self.0.len() >= MOST => Some(0),
            _ => None,
        };
        let left = leaves.map(|place| self.0.remove(place).1);
        self.0.push((from, connection));
        left
    }

    /// Removes one that has ended.
    pub(crate) fn leave(&mut self, is_over: impl Fn(&T) -> bool) {
        self.0.retain(|(_, connection)| !is_over(connection));
    }
}

/// The origin of a connection: for IPv6 the network, which has more addresses than the limit.
pub(crate) fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            IpAddr::V6(Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0))
        }
        address @ IpAddr::V4(_) => address,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn address(last: u8) -> IpAddr {
        IpAddr::from([10, 0, 0, last])
    }

    #[test]
    fn the_oldest_of_an_address_makes_room_for_its_next() {
        let mut pending = Pending::default();
        assert_eq!(pending.enter(address(1), 0), None);
        for number in 0..MOST_FROM_ONE {
            assert_eq!(pending.enter(address(2), 100 + number), None);
        }
        assert_eq!(pending.enter(address(2), 500), Some(100), "not that of another address");
        assert_eq!(pending.enter(address(2), 501), Some(101));
        pending.leave(|&it| it == 102);
        assert_eq!(pending.enter(address(2), 502), None);
    }

    #[test]
    fn many_addresses_have_no_more_than_all_may() {
        let mut pending = Pending::default();
        let left = (0..2 * MOST)
            .filter(|&number| pending.enter(address(u8::try_from(number % 250).unwrap()), number).is_some());
        assert_eq!(left.count(), MOST);
        assert_eq!(pending.0.len(), MOST);
        assert_eq!(pending.0[0].1, MOST, "the oldest have left");
    }

    #[test]
    fn a_network_of_ipv6_is_one() {
        let of = |text: &str| network(text.parse().unwrap());
        assert_eq!(of("2001:db8::1"), of("2001:db8::ffff:1"));
        assert_ne!(of("2001:db8::1"), of("2001:db8:0:1::1"));
        assert_eq!(of("::ffff:10.0.0.1"), of("10.0.0.1"));
    }
}
