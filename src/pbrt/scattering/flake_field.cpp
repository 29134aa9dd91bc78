#include "pbrt/scattering/flake_field.h"

namespace lacquer {

int FlakeField::Count(const FlakeWindow& window) const {
    int count = 0;
    Descend(window, [&](const Node& node) {
        if (IsWithin(node, window)) {
            count += node.count;
            return false;
        }
        if (!node.IsLeaf()) return true;
        for (int i = 0; i < node.count; ++i) count += window.Contains(FlakeOf(node, i).offset);
        return false;
    });
    return count;
}

// In the order of Descend(), which is the same each time: nodes within the window are passed as wholes until
// the one that holds the index, and that is taken apart.
Flake FlakeField::Pick(const FlakeWindow& window, int index) const {
    Flake picked;
    Descend(window, [&](const Node& node) {
        if (index < 0) return false;
        if (index >= node.count && IsWithin(node, window)) {
            index -= node.count;
            return false;
        }
        if (!node.IsLeaf()) return true;
        for (int i = 0; i < node.count && index >= 0; ++i)
            if (const Flake flake = FlakeOf(node, i); window.Contains(flake.offset) && index-- == 0)
                picked = flake;
        return false;
    });
    return picked;
}

}  // namespace lacquer
