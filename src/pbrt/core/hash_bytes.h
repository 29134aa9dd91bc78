// Hash of any number of bytes.
#pragma once

#include <algorithm>
#include <cstring>
#include <string_view>

#include "pbrt/core/rng.h"

namespace lacquer {

/// Tells texts and files apart; not meant to withstand somebody who wants two of them to look alike.
inline uint64_t HashOfBytes(std::string_view bytes) {
    uint64_t hash = bytes.size();
    for (; !bytes.empty(); bytes.remove_prefix(std::min(bytes.size(), sizeof(uint64_t)))) {
        uint64_t word = 0;
        std::memcpy(&word, bytes.data(), std::min(bytes.size(), sizeof word));
        hash = Hash(hash, word);
    }
    return hash;
}

}  // namespace lacquer
