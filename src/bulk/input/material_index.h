// Indices of refraction that particles take from the renderer's materials.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bulk/table/bulk_computation.h"

namespace lacquer::bulk {

/// Where the renderer's named spectra are known [nm].
inline constexpr double kNamedIndexFirst = 360, kNamedIndexLast = 830;

/// The index of "metal-Au", from the spectra metal-Au-eta and metal-Au-k, or of "glass-BK7", at the given
/// wavelengths [nm]; none if there is no such material.
std::optional<OpticalIndex> NamedIndex(std::string_view name, std::span<const double> wavelengths);
/// Names that NamedIndex() knows.
std::vector<std::string> NamedIndices();

}  // namespace lacquer::bulk
