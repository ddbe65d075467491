//! Names the shared library for the loader: programs ask for `libmoulage.so.0.1` or
//! `@rpath/libmoulage.0.1.dylib`, so that a later version that breaks them can stand beside this one.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let [major, minor] = ["MAJOR", "MINOR"]
        .map(|part| std::env::var(format!("CARGO_PKG_VERSION_{part}")).unwrap_or_default());
    let arguments = match std::env::var("CARGO_CFG_TARGET_OS").as_deref() {
        Ok("linux") => vec![format!("-Wl,-soname,libmoulage.so.{major}.{minor}")],
        Ok("macos") => {
            vec!["-install_name".into(), format!("@rpath/libmoulage.{major}.{minor}.dylib")]
        }
        _ => vec![],
    };
    for argument in arguments {
        println!("cargo:rustc-cdylib-link-arg={argument}");
    }
}
