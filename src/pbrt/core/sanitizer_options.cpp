// Part of sanitized programs alone: options of the sanitizers that they start with. ASAN_OPTIONS and
// TSAN_OPTIONS add to them.

// LLVM 14 takes what stands before thread-local memory of libraries that are loaded late (OpenImageIO) for
// its size, and the search for leaks crashes on it.
// NOLINTNEXTLINE(readability-identifier-naming): the sanitizer asks for this name
extern "C" const char* __asan_default_options() { return "intercept_tls_get_addr=0"; }

// Libraries are built without it: what it meets there are halves of what happens.
// NOLINTNEXTLINE(readability-identifier-naming): the sanitizer asks for this name
extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }
