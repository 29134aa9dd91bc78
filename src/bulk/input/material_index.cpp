#include "bulk/input/material_index.h"

#include <algorithm>

#include "pbrt/core/spectrum.h"

namespace lacquer::bulk {
namespace {

constexpr std::string_view kGlass = "glass-", kMetal = "metal-", kEta = "-eta", kAbsorption = "-k";

}  // namespace

std::vector<std::string> NamedIndices() {
    std::vector<std::string> names;
    for (const std::string& name : NamedSpectra()) {
        if (name.starts_with(kGlass)) names.push_back(name);
        if (name.starts_with(kMetal) && name.ends_with(kEta))
            names.push_back(name.substr(0, name.size() - kEta.size()));
    }
    return names;
}

std::optional<OpticalIndex> NamedIndex(std::string_view name, std::span<const double> wavelengths) {
    const std::vector<std::string> known = NamedIndices();
    if (std::find(known.begin(), known.end(), name) == known.end()) return {};
    const bool isGlass = name.starts_with(kGlass);
    const std::string stem(name);
    const std::unique_ptr<Spectrum> n = NamedSpectrum(isGlass ? stem : stem + std::string(kEta)),
                                    k = isGlass ? nullptr : NamedSpectrum(stem + std::string(kAbsorption));
    std::vector<OpticalIndex::Node> nodes;
    for (const double wavelength : wavelengths)
        nodes.push_back({wavelength, Complex(double(n->Evaluate(float(wavelength))),
                                             k ? double(k->Evaluate(float(wavelength))) : 0.)});
    return OpticalIndex(std::move(nodes));
}

}  // namespace lacquer::bulk
