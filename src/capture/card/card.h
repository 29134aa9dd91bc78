// The printed card: sixteen tags around a window, which tell where a camera stood.
//
// Its unit is a 18th of its size. In units, with the origin in its middle, x right and y up: tags have edges
// of 2, their centres lie at -8, -4, 0, 4, 8 along the rim; the window is the square [-6, 6]^2.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::capture {

inline constexpr int kNumTags = 16;          ///< of family 36h11 [Olson 2011], ids from 0
inline constexpr double kUnitsPerSize = 18;  ///< the size is the outer edge of the square of tags
inline constexpr double kTagUnits = 2;       ///< edge of a tag's black square
inline constexpr double kWindowUnits = 12;   ///< edge of the window, which is cut out
inline constexpr double kPageUnits = 21;     ///< edge of the drawing, a square around all of it
/// Edge of the square of the sample that is used, in sizes: [Guo 2021] take 10.88 cm of 17.
inline constexpr double kSampleShare = 0.64;
/// Sizes that a card can have [cm].
inline constexpr double kMinCardSize = 1, kMaxCardSize = 500;

/// Ids run clockwise from the top left. Units of the card. @param id  in [0, kNumTags)
Eigen::Vector2d TagCenter(int id);
/// Corners 0 to 3 of the black square: lower left, lower right, upper right, upper left.
Eigen::Vector2d TagCorner(int id, int corner);
/// All four in cm. @param size  of the card [cm]
std::array<Eigen::Vector2d, 4> TagCorners(int id, double size);

/// A black rectangle of the drawing; units of the card.
struct CardRect {
    Eigen::Vector2d min, max;
};
/// The black cells of a tag, runs of each row together.
std::vector<CardRect> TagRects(int id);
/// What else is black: the hair line around the window, and a scale bar to measure the print by.
std::vector<CardRect> CardMarks(double size);
/// Length of the scale bar, one, two or five times a power of ten, for cards of that size [cm].
double ScaleBarLength(double size);

/// A drawing with physical size, for printing at 100 %: the tags, the window, ids, a scale bar with its
/// length.
/// @param size  of the card [cm]. Errors: std::invalid_argument beyond kMinCardSize and kMaxCardSize
std::string CardSvg(double size);

/// The drawing without its text, as an image of one channel: 0 where it is black, 1 where it is white,
/// between them by covered area. It shows kPageUnits in both directions. @param pixelsPerUnit  a multiple of
/// 4 has cells of whole pixels
Image CardImage(double size, int pixelsPerUnit);

}  // namespace lacquer::capture
