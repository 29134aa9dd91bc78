// What pages that need no other file are made of: sentences, escaped text, and bytes as text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// A message of a command as a sentence: its first letter a capital, and a full stop.
std::string Sentence(std::string message);

/// Text for HTML, also within a quoted attribute: & < > " ' become entities.
std::string EscapeHtml(std::string_view text);

/// JSON for a <script type="application/json"> element: the same value, written without < > & and line
/// separators, so that no string of it can end the element. Bytes that are not UTF-8 become U+FFFD; numbers
/// that are not finite become null.
std::string JsonForPage(const nlohmann::ordered_json& value);

/// RFC 4648, with padding.
std::string ToBase64(std::string_view bytes);

/// zlib's format at its default level. Errors: std::runtime_error if memory runs out.
std::string Deflated(std::string_view bytes);

/// The first channel, or R, G, B in linear sRGB where the image has them, as 16-bit floats: channel after
/// channel, all high bytes, then all low bytes (which deflates better than whole numbers). Finite values
/// beyond the range of 16-bit floats become the largest one; NaN and infinity stay what they are.
std::string PixelsForPage(const Image& image);
/// Channels that PixelsForPage takes: 1 or 3.
int NumPageChannels(const Image& image);

}  // namespace lacquer::cmd
