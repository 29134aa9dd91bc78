#include "pbrt/phases/oriented_file.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "pbrt/core/check.h"
#include "pbrt/core/output_file.h"
#include "pbrt/image/image.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer {
namespace {

constexpr double kNormTolerance = 1e-4, kReciprocityTolerance = 1e-3;

std::string ChannelName(double wavelength) { return fmt::format("p.{:.9g}", wavelength); }

/// "an incidence of 30 degrees at 550 nm"
std::string PlaceOf(const OrientedBulkTable& table, size_t row, size_t incidence) {
    return fmt::format("an incidence of {:.9g} degrees at {:.9g} nm", table.angles[incidence],
                       table.wavelengths[row]);
}

void CheckNumbers(const OrientedBulkTable& table, const OrientedGrid& grid, size_t row,
                  const FileLoc& image) {
    const std::vector<float>& p = table.phase[row];
    for (size_t i = 0; i < grid.NumIncidences(); ++i)
        for (size_t at = grid.Index(i, 0); at < grid.Index(i + 1, 0); ++at)
            if (!(p[at] >= 0 && std::isfinite(p[at])))
                throw SceneError(
                    image, fmt::format("a phase function is {} for {}; expected numbers of at least 0", p[at],
                                       PlaceOf(table, row, i)));
    for (size_t i = 0; i < grid.NumIncidences(); ++i)
        if (const double norm = grid.OverSphere<float>(p, i); !(std::abs(norm - 1) <= kNormTolerance))
            throw SceneError(image, fmt::format("the phase function for {} integrates to {:.9g} over all "
                                                "directions; expected 1 to within {}",
                                                PlaceOf(table, row, i), norm, kNormTolerance));
}

void CheckReciprocity(const OrientedBulkTable& table, const OrientedGrid& grid, size_t row,
                      const FileLoc& image) {
    const std::vector<float>& p = table.phase[row];
    const std::vector<double>& sigma = table.sigmaS[row];
    // Digits of what is nearly 0 do not count.
    constexpr double kNothing = 1e-7;
    for (size_t i = 0; i < grid.NumIncidences(); ++i)
        for (size_t j = 0; j < grid.NumAngles(); ++j) {
            const auto [a, b] = grid.Reciprocal(i, j);
            for (size_t k = 0; k < grid.NumAzimuths(); ++k) {
                const double there = sigma[i] * double(p[grid.Index(i, j) + k]),
                             back = sigma[a] * double(p[grid.Index(a, b) + k]);
                if (std::abs(there - back) <=
                    kReciprocityTolerance * std::max(there, back) + kNothing * sigma[i])
                    continue;
                throw SceneError(
                    image, fmt::format("what is scattered from {} to {:.9g} degrees is {:.9g} times that of "
                                       "the way back; expected the same (reciprocity)",
                                       PlaceOf(table, row, i), table.angles[j], there / back));
            }
        }
}

}  // namespace

void ReadOrientedPhase(const std::string& path, const FileLoc& loc, OrientedBulkTable* table) {
    const OrientedGrid grid(*table);
    const std::string name = (std::filesystem::path(path).parent_path() / table->phaseFile).string();
    const FileLoc place{name, 0, 0};
    const Image image = ReadImage(name, ColorEncoding{}, loc);
    const Int2 expected(int(grid.NumAzimuths()), int(grid.NumIncidences() * grid.NumAngles()));
    if (image.Resolution() != expected)
        throw SceneError(place,
                         fmt::format("this image has {} x {} pixels; expected {} x {}: a column for "
                                     "each azimuth, and for each incidence a row for each angle",
                                     image.Resolution().x, image.Resolution().y, expected.x, expected.y));
    table->phase.clear();
    for (size_t row = 0; row < table->wavelengths.size(); ++row) {
        const std::string channel = ChannelName(table->wavelengths[row]);
        const int c = image.FindChannel(channel);
        if (c < 0)
            throw SceneError(place, fmt::format("this image has no channel \"{}\"{}", channel,
                                                DidYouMean(channel, image.Channels())));
        std::vector<float>& p = table->phase.emplace_back();
        p.reserve(grid.Size());
        for (int y = 0; y < expected.y; ++y)
            for (int x = 0; x < expected.x; ++x) p.push_back(image.Get({x, y}, c));
        CheckNumbers(*table, grid, row, place);
        CheckReciprocity(*table, grid, row, place);
    }
}

std::string ImageOfOrientedBulk(const std::string& path) {
    return std::filesystem::path(path).replace_extension("exr").string();
}

void WriteOrientedBulk(OrientedBulkTable table, const std::string& path) {
    const OrientedGrid grid(table);
    const std::string image = ImageOfOrientedBulk(path);
    table.phaseFile = std::filesystem::path(image).filename().string();
    std::vector<std::string> channels;
    for (const double wavelength : table.wavelengths) channels.push_back(ChannelName(wavelength));
    Image pixels(Int2(int(grid.NumAzimuths()), int(grid.NumIncidences() * grid.NumAngles())), channels);
    for (size_t row = 0; row < channels.size(); ++row) {
        LACQUER_CHECK(table.phase[row].size() == grid.Size());
        for (size_t i = 0; i < grid.Size(); ++i)
            pixels.Pixels()[i * channels.size() + row] = table.phase[row][i];
    }
    WriteImage(pixels, image);
    OutputFile file(path);
    file.Write(WriteBulkTable(table));
    file.Finish();
}

}  // namespace lacquer
