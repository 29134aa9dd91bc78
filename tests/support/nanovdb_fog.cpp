#include "support/nanovdb_fog.h"

#include <unistd.h>

#include <filesystem>

#include "support/nanovdb_library.h"

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
