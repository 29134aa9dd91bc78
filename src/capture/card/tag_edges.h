// Corners of a tag to a small part of a pixel, by its edges.
#pragma once

#include <Eigen/Core>
#include <array>

#include "pbrt/image/image.h"

namespace lacquer::capture {

/// Part of an edge that its line is fitted to, in the middle: near corners two edges blur into each other.
inline constexpr double kEdgeShare = 0.8;

/// Moves the corners of a dark square on white to where the lines along its edges meet. Each line is fitted
/// to points that keep the amount of light across the edge, which no symmetrical blur moves [Tabatabai and
/// Mitchell 1984]. Errors of the two ends of a line are those of a straight line through equally good points:
/// see TagResidual in calibration.cpp. False, and nothing changed, where there are no such edges nearby.
/// @param grey  one channel of linear values
/// @param numCells  of the square along an edge; the outer ones are dark
bool RefineCorners(const Image& grey, int numCells, std::array<Eigen::Vector2d, 4>* corners);

}  // namespace lacquer::capture
