//! Whatever stands in a pipeline, a config or a `--set`, there is an answer with a place, and no crash.

use crate::plan_mistakes::messages;
use motionmill::plan::shipped::CONFIGS;

#[test]
fn deep_nesting_is_a_mistake_and_no_crash() {
    let deep = 100_000;
    for config in [
        format!("a = {}", "[".repeat(deep)),
        format!("a = {}", "{a=".repeat(deep)),
        format!("{}a = 1", "a.".repeat(deep)),
        format!("[{}a]", "a.".repeat(deep)),
    ] {
        let said = messages(None, Some(&config), &[]);
        assert!(said.starts_with("error: config.toml:1:"), "{}", &said[..said.len().min(200)]);
    }
    for set in [format!("{}a=1", "a.".repeat(deep)), format!("a={}", "[".repeat(deep))] {
        assert!(messages(None, None, &[&set]).contains(": more than 64 sections or lists within each other\n"));
    }
    // Dots in text, in comments and in numbers are no depth.
    let dots = format!(
        "# {0}\n[graph]\nthresholds_m2 = [0.1, 0.2, 0.3, 0.4, 0.5]\n[inputs]\nskip = ['{0}', \"\\\"{0}\"]\n",
        ". ".repeat(100)
    );
    assert_eq!(messages(None, Some(&dots), &[]), "no mistake\n");
}

proptest::proptest! {
    /// Whatever stands in a file, there is an answer, and each error has a place in the file.
    #[test]
    fn no_text_makes_it_panic(text in "[\\[\\]a-z_=.\"'#0-9{},\n é-]{0,80}") {
        messages(Some(&text), Some(&text), &[&text]);
    }

    /// Cut anywhere, the default config still gives places or a config.
    #[test]
    fn a_cut_config_gives_places(at in 0usize..9000) {
        let text = CONFIGS[0].text;
        let mut at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let said = messages(None, Some(&text[..at]), &[]);
        proptest::prop_assert!(said == "no mistake\n" || said.starts_with("error: config.toml:"), "{}", said);
    }
}
