#include "support/nanovdb_fog.h"

#include <unistd.h>

#include <filesystem>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <nanovdb/util/IO.h>
#include <nanovdb/util/Primitives.h>
#pragma GCC diagnostic pop

namespace lacquer::test {
namespace {

struct TemporaryFog {
    std::string path =
        std::filesystem::temp_directory_path() / ("lacquer-fog-" + std::to_string(getpid()) + ".nvdb");
    TemporaryFog() {
        nanovdb::io::writeGrid(
            path, nanovdb::createFogVolumeSphere<float>(1.f, nanovdb::Vec3f(0.3f, -0.2f, 0.5f), 0.05, 3.0,
                                                        nanovdb::Vec3d(0.01), "density"));
    }
    TemporaryFog(const TemporaryFog&) = delete;
    TemporaryFog& operator=(const TemporaryFog&) = delete;
    ~TemporaryFog() { std::filesystem::remove(path); }
};

}  // namespace

const std::string& FogFile() {
    static const TemporaryFog fog;
    return fog.path;
}

}  // namespace lacquer::test
