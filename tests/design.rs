//! The design file.
use nailnoise::design::Design;
#[test]
fn loads() {
    for f in ["designs/n80cb.toml","designs/n80cb-sandbox.toml","tests/data/small.toml"] {
        let d = match Design::load(f) { Ok(d) => d, Err(e) => panic!("{:?}", miette::Report::new(e)) };
        println!("{} {} {:?}", d.name(), d.digest(), d.warnings().iter().map(|w| w.to_string()).collect::<Vec<_>>());
    }
}
