// Part of sanitized programs alone: options of the address sanitizer that they start with. ASAN_OPTIONS adds
// to them.

// LLVM 14 takes what stands before thread-local memory of libraries that are loaded late (OpenImageIO) for
// its size, and the search for leaks crashes on it.
// NOLINTNEXTLINE(readability-identifier-naming): the sanitizer asks for this name
extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }
