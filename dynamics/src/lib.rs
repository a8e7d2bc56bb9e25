//! The nailing cycle of a pneumatic nailer: gas, motion, contacts and events.
