struct Wrong;

hal_component::export!(Wrong);

fn main() {}
