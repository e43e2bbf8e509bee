/* For starts.comp: a name that a declaration uses. */
enum { STARTS_AT = 42 };
