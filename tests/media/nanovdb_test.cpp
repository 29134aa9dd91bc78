// Medium "nanovdb": values against the library's, packed files, and damaged ones.
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "media/medium_fixtures.h"
#include "pbrt/media/nanovdb_file.h"
#include "support/nanovdb_library.h"

namespace lacquer::test::nanovdb_test {
namespace {

using nanovdb::io::Codec;

/// A folder that goes away with the test.
class NanoVdb : public testing::Test {
  protected:
    NanoVdb()
        : folder_(std::filesystem::temp_directory_path() / ("lacquer-nanovdb-" + std::to_string(getpid()))) {
        std::filesystem::create_directories(folder_);
    }
    ~NanoVdb() override { std::filesystem::remove_all(folder_); }
    std::string Path(const std::string& name) const { return (folder_ / name).string(); }
    std::string Write(const std::string& name, const std::string& bytes) const {
        std::ofstream(Path(name), std::ios::binary) << bytes;
        return Path(name);
    }
    static std::string Bytes(const std::string& path) {
        std::ifstream file(path, std::ios::binary);
        return {std::istreambuf_iterator<char>(file), {}};
    }

    std::filesystem::path folder_;
};

/// A ball of fog of radius 20 voxels of size 0.05, off the origin.
nanovdb::GridHandle<> Fog(const char* name = "density",
                          nanovdb::ChecksumMode sums = nanovdb::ChecksumMode::Partial) {
    return nanovdb::createFogVolumeSphere<float>(1.f, nanovdb::Vec3f(0.3f, -0.2f, 0.5f), 0.05, 3.0,
                                                 nanovdb::Vec3d(0.01), name, nanovdb::StatsMode::Default,
                                                 sums);
}
/// Values a + b i + c j of index, on a brick that straddles blocks, with a tile of 8^3 and a background.
nanovdb::GridHandle<> Ramp(const char* name, float background) {
    nanovdb::GridBuilder<float> builder(background);
    auto accessor = builder.getAccessor();
    for (int i = -5; i < 12; ++i)
        for (int j = 3; j < 20; ++j)
            for (int k = -9; k < 2; ++k)
                accessor.setValue({i, j, k}, 1 + 0.1f * float(i + 5) + 0.05f * float(j - 3));
    return builder.getHandle<>(0.5, nanovdb::Vec3d(1, 2, 3), name);
}

std::string Text(const std::string& path, const std::string& more = "") {
    return "\"string filename\" \"" + path + "\" \"rgb sigma_s\" [0 0 0] " + more;
}

/// Compares with the library's interpolation at points of the bounds.
void ExpectLibraryValues(const Medium& medium, const nanovdb::FloatGrid& grid, Rng& rng,
                         int numPoints = 500) {
    const auto box = grid.worldBBox();
    const auto sampler = nanovdb::createSampler<1>(grid.tree());
    double largest = 0;
    for (int i = 0; i < numPoints; ++i) {
        nanovdb::Vec3d p;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = box.min()[axis] + double(rng.Uniform()) * (box.max()[axis] - box.min()[axis]);
        const float expected = sampler(grid.worldToIndex(p));
        const float found =
            medium.At(Point3(float(p[0]), float(p[1]), float(p[2])), SomeWavelengths()).sigma_a[0];
        ASSERT_NEAR(found, expected, 2e-4) << "rounding of an index";
        largest = std::max(largest, double(expected));
    }
    EXPECT_GT(largest, 0.9);
}

TEST_F(NanoVdb, HasTheValuesOfTheLibraryHoweverPacked) {
    Rng rng(SeedOf(FullTestName()));
    const auto fog = Fog(), ramp = Ramp("density", 0);
    for (const Codec codec : {Codec::NONE, Codec::ZIP, Codec::BLOSC}) {
        nanovdb::io::writeGrid(Path("fog.nvdb"), fog, codec);
        const auto medium = MakeMedium("nanovdb", Text(Path("fog.nvdb")));
        ExpectLibraryValues(*medium, *fog.grid<float>(), rng);
        EXPECT_FALSE(medium->IsEmissive());
        nanovdb::io::writeGrid(Path("ramp.nvdb"), ramp, codec);
        ExpectLibraryValues(*MakeMedium("nanovdb", Text(Path("ramp.nvdb"))), *ramp.grid<float>(), rng);
    }
}

TEST_F(NanoVdb, IsEmptyOutsideOfItsBounds) {
    nanovdb::io::writeGrid(Path("a.nvdb"), Ramp("density", 0));
    const auto medium = MakeMedium("nanovdb", Text(Path("a.nvdb")));
    // Voxel -5 ... 11 along x, at 1 + i/2.
    EXPECT_GT(medium->At({-1.49f, 5, 2}, SomeWavelengths()).sigma_a[0], 0.9f);
    EXPECT_EQ(medium->At({-1.51f, 5, 2}, SomeWavelengths()).sigma_a[0], 0)
        << "cut off at the first voxel, as pbrt-v4";
    EXPECT_NEAR(medium->At({6.75f, 3.5f, 2}, SomeWavelengths()).sigma_a[0], 2.6f / 2, 1e-4)
        << "fades behind the last";
    EXPECT_EQ(medium->At({7.01f, 5, 2}, SomeWavelengths()).sigma_a[0], 0);
}

TEST_F(NanoVdb, BoundsHold) {
    Rng rng(SeedOf(FullTestName()));
    nanovdb::io::writeGrid(Path("fog.nvdb"), Fog());
    nanovdb::io::writeGrid(Path("ramp.nvdb"), Ramp("density", 0));
    for (const char* name : {"fog.nvdb", "ramp.nvdb"})
        for (const char* scale : {"\"float scale\" 0.1", "\"float scale\" 100"}) {
            const auto medium = MakeMedium("nanovdb", Text(Path(name), scale));
            const Bounds3 box = name[0] == 'f' ? Bounds3({-0.8f, -1.3f, -0.6f}, {1.4f, 0.9f, 1.6f})
                                               : Bounds3({-2, 3, -2}, {8, 13, 5});
            EXPECT_TRUE(BoundsHold(*medium, box, rng, 200, 40, 1e-4)) << name;
            EXPECT_FALSE(BoundsHold(*medium, box, rng, 200, 40, 1e-4, 0.7)) << "control " << name;
        }
}

TEST_F(NanoVdb, GlowsByTheTemperatureGrid) {
    std::vector<nanovdb::GridHandle<>> grids;
    grids.push_back(Ramp("density", 0));
    grids.push_back(Ramp("temperature", 0));
    grids.push_back(Ramp("heat", 0));
    nanovdb::io::writeGrids(Path("a.nvdb"), grids);
    const SampledWavelengths lambda = SomeWavelengths();
    const Point3 p(1, 5, 2);  // index (0, 6, -2): 1.65
    const auto medium = MakeMedium("nanovdb", Text(Path("a.nvdb"),
                                                   "\"float temperatureoffset\" 0.65 "
                                                   "\"float temperaturescale\" 2000 \"float Lescale\" 3"));
    ASSERT_TRUE(medium->IsEmissive());
    EXPECT_NEAR(medium->At(p, lambda).Le[0] / (3 * BlackbodySpectrum(2000).Sample(lambda)[0]), 1, 1e-3);
    EXPECT_TRUE(
        MakeMedium("nanovdb", Text(Path("a.nvdb"), "\"string temperaturename\" \"heat\""))->IsEmissive());
    EXPECT_FALSE(MakeMedium("nanovdb", Text(Path("a.nvdb"), "\"float Lescale\" 0"))->IsEmissive());
    const std::string message = MediumErrorOf(
        "nanovdb", Text(Path("a.nvdb"), "\"string temperaturename\" \"hot\" \"string gridname\" \"heat\""));
    EXPECT_NE(message.find("no grid \"hot\"; it has \"density\", \"temperature\", \"heat\""),
              std::string::npos)
        << message;
}

TEST_F(NanoVdb, TakesNegativeValuesForNothing) {
    nanovdb::GridBuilder<float> builder(0);
    auto accessor = builder.getAccessor();
    for (int i = 0; i < 4; ++i) accessor.setValue({i, 0, 0}, float(i) - 2);
    nanovdb::io::writeGrid(Path("a.nvdb"), builder.getHandle<>(1, nanovdb::Vec3d(0), "density"));
    const auto medium = MakeMedium("nanovdb", Text(Path("a.nvdb")));
    EXPECT_EQ(medium->At({0, 0, 0}, SomeWavelengths()).sigma_a[0], 0);
    EXPECT_EQ(medium->At({3, 0, 0}, SomeWavelengths()).sigma_a[0], 1);
}

TEST_F(NanoVdb, TakesEmptyGrids) {
    nanovdb::GridBuilder<float> builder(0);
    nanovdb::io::writeGrid(Path("a.nvdb"), builder.getHandle<>(1, nanovdb::Vec3d(0), "density"));
    const auto medium = MakeMedium("nanovdb", Text(Path("a.nvdb")));
    EXPECT_EQ(medium->At({0, 0, 0}, SomeWavelengths()).sigma_a[0], 0);
    MajorantSegment segment;
    EXPECT_FALSE(medium->Majorants({{-5, 0, 0}, {1, 0, 0}}, 10, SomeWavelengths()).Next(&segment));
}

TEST_F(NanoVdb, SaysWhatIsWrong) {
    const auto expect = [&](const std::string& path, const std::vector<const char*>& parts,
                            const std::string& more = "") {
        const std::string message = MediumErrorOf("nanovdb", Text(path, more));
        for (const char* part : parts)
            EXPECT_NE(message.find(part), std::string::npos) << "\"" << message << "\" lacks " << part;
    };
    EXPECT_NE(MediumErrorOf("nanovdb", "").find("needs \"string filename\""), std::string::npos);
    EXPECT_THROW(MakeMedium("nanovdb", Text(Path("none.nvdb"))), FileError);
    expect(Write("text.nvdb", "Shape \"sphere\""), {"text.nvdb", "is not a NanoVDB file"});
    expect(Write("empty.nvdb", ""), {"is not a NanoVDB file"});
    nanovdb::io::writeGrid(Path("fog.nvdb"), Fog("smoke"));
    expect(Path("fog.nvdb"), {"no grid \"density\"", "\"smoke\""});
    const std::string fog = Bytes(Path("fog.nvdb"));
    expect(Write("cut.nvdb", fog.substr(0, fog.size() / 2)), {"ends within the grid \"smoke\""});
    expect(Write("head.nvdb", fog.substr(0, 100)), {"ends within its list"});
    std::string old = fog;
    old[8 + 3] = 3;  // the upper bits of the version
    expect(Write("old.nvdb", old), {"version", "32 is expected"});
    nanovdb::io::writeGrid(
        Path("set.nvdb"),
        nanovdb::createLevelSetSphere<float>(1.f, nanovdb::Vec3f(0), 0.1, 3.0, nanovdb::Vec3d(0), "density"));
    expect(Path("set.nvdb"), {"not a fog volume"});
    nanovdb::io::writeGrid(Path("double.nvdb"),
                           nanovdb::createFogVolumeSphere<double>(1.0, nanovdb::Vec3d(0), 0.1, 3.0,
                                                                  nanovdb::Vec3d(0), "density"));
    expect(Path("double.nvdb"), {"double", "floats are expected"});
    nanovdb::GridBuilder<float> builder(0);
    builder.getAccessor().setValue({0, 0, 0}, std::numeric_limits<float>::quiet_NaN());
    nanovdb::io::writeGrid(Path("nan.nvdb"), builder.getHandle<>(1, nanovdb::Vec3d(0), "density"));
    expect(Path("nan.nvdb"), {"not finite"});
    nanovdb::GridBuilder<float> wide(0);
    wide.getAccessor().setValue({0, 0, 0}, 1);
    wide.getAccessor().setValue({1 << 20, 1 << 20, 1 << 20}, 1);
    nanovdb::io::writeGrid(Path("wide.nvdb"), wide.getHandle<>(1, nanovdb::Vec3d(0), "density"));
    expect(Path("wide.nvdb"), {"spans", "the limit is"});
}

TEST_F(NanoVdb, NoticesChangedBytesByChecksums) {
    Rng rng(SeedOf(FullTestName()));
    nanovdb::io::writeGrid(Path("full.nvdb"), Fog("density", nanovdb::ChecksumMode::Full));
    EXPECT_EQ(MediumErrorOf("nanovdb", Text(Path("full.nvdb"))), "");
    const std::string good = Bytes(Path("full.nvdb"));
    for (int i = 0; i < 20; ++i) {
        std::string bad = good;
        bad[300 + rng.UniformInt(uint32_t(bad.size()) - 300)] ^= char(1 << rng.UniformInt(8));
        // Some bytes between the nodes belong to nothing.
        EXPECT_NE(MediumErrorOf("nanovdb", Text(Write("bad.nvdb", bad))).find("checksum"), std::string::npos)
            << i;
    }
}

/// Makes the medium of a damaged file, and a few look-ups if that succeeds; whatever happens, a SceneError or
/// nothing.
void TryDamaged(const std::string& path, Rng& rng) {
    try {
        const auto medium = MakeMedium("nanovdb", Text(path, "\"string temperaturename\" \"density\""));
        for (int i = 0; i < 20; ++i) {
            const Ray ray{4.f * RandomPoint(rng) - 2.f, RandomDirection(rng)};
            medium->At(ray.o, SomeWavelengths());
            MajorantWalk walk = medium->Majorants(ray, 10, SomeWavelengths());
            int segments = 0;
            for (MajorantSegment s; segments < 1000 && walk.Next(&s);) ++segments;
            EXPECT_LT(segments, 1000);
        }
    } catch (const SceneError& e) {
        EXPECT_NE(std::string(e.what()).find(path), std::string::npos);
    }
}

TEST_F(NanoVdb, SurvivesDamage) {
    // Without checksums, so that damage gets as far as it can. LACQUER_FUZZ_ROUNDS for more than a quick
    // look.
    const char* wanted = std::getenv("LACQUER_FUZZ_ROUNDS");
    const int rounds = wanted ? std::atoi(wanted) : 60;
    Rng rng(SeedOf(FullTestName()));
    nanovdb::GridBuilder<float> builder(0);
    auto accessor = builder.getAccessor();
    for (int i = 0; i < 20; ++i) accessor.setValue({i, 3 * i, -i}, 1);
    const auto small = builder.getHandle<>(1, nanovdb::Vec3d(0), "density", nanovdb::GridClass::FogVolume);
    auto* grid = const_cast<nanovdb::FloatGrid*>(small.grid<float>());
    nanovdb::updateChecksum(*grid, nanovdb::ChecksumMode::Disable);
    for (const Codec codec : {Codec::NONE, Codec::ZIP, Codec::BLOSC}) {
        nanovdb::io::writeGrid(Path("good.nvdb"), small, codec);
        const std::string good = Bytes(Path("good.nvdb"));
        for (int i = 0; i < rounds; ++i) {
            std::string bad = good;
            // Most of the file is empty tables: half of the changes go to the headers, or to words that are
            // not 0.
            const int changes = 1 + int(rng.UniformInt(4));
            for (int j = 0; j < changes; ++j) {
                size_t at = rng.UniformInt(uint32_t(bad.size()));
                if (j % 2 == 0) at = rng.UniformInt(uint32_t(std::min<size_t>(bad.size(), 1200)));
                if (j % 4 == 1)
                    while (at + 1 < bad.size() && bad[at] == 0) ++at;
                if (rng.UniformInt(2))
                    bad[at] ^= char(1 << rng.UniformInt(8));
                else
                    bad[at] = char(rng.UniformInt(256));
            }
            if (rng.UniformInt(4) == 0) bad.resize(rng.UniformInt(uint32_t(bad.size())));
            TryDamaged(Write("bad.nvdb", bad), rng);
        }
    }
}

}  // namespace
}  // namespace lacquer::test::nanovdb_test
