"""Pictures from one process to another: one small program a library, all by the protocol of `peers.protocol`."""
