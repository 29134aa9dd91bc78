// The program of all fuzz targets, for libFuzzer: lacquer_fuzz --target=NAME [options of libFuzzer]
// [FOLDER|FILE ...].
// --list prints the names.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "fuzz/fuzz_target.h"
#include "pbrt/core/parallel.h"

namespace {

lacquer::fuzz::FuzzTarget theTarget = nullptr;

using Targets = lacquer::Registry<lacquer::fuzz::FuzzTargetKind>;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
    constexpr std::string_view kOption = "--target=";
    for (int i = 1; i < *argc; ++i) {
        const std::string_view argument = (*argv)[i];
        if (argument == "--list") {
            for (const std::string& name : Targets::Names()) std::printf("%s\n", name.c_str());
            std::exit(0);
        }
        if (argument.starts_with(kOption))
            theTarget = Targets::Find(std::string(argument.substr(kOption.size())));
    }
    if (!theTarget) {
        std::fprintf(stderr, "lacquer_fuzz wants --target=NAME with a name that --list prints\n");
        std::exit(1);
    }
    // One input gives the same coverage each time, and processes share the processors.
    static const lacquer::ThreadLimit limit(1);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    lacquer::fuzz::Accepts(theTarget, {reinterpret_cast<const char*>(data), size});
    return 0;
}
