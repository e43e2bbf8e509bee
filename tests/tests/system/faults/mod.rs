//! Faults: components, clients, files and processes that fail or attack.

mod blocked;
mod clients;
mod crashes;
mod edits;
mod ends;
mod false_engine;
mod gaps;
mod growth;
mod instances;
mod libraries;
mod lost_machine;
mod messages;
mod pin_pages;
mod plugin_files;
mod recordings;
mod running;
