//! Contracts: messages, keys, codec and scenario files.
