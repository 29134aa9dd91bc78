// From the parameters of layered materials to their stacks and settings.
#pragma once

#include "layered/materials/layered_material.h"

namespace lacquer::layered {

/// The layers that `"string stack"` names, outermost first, nested stacks taken apart. Two interfaces in a
/// row have nothing between them. "interface" and "" stand for the interface that is not there. Empty if a
/// layer could not be made: that has been reported already. Errors: SceneError at the parameter that names
/// the entry: unknown names, the stack itself, no entry at all, a slab first or last or next to another, an
/// opaque interface above another, a mixture, too many interfaces.
StackEntries ReadStack(const MaterialArgs& args);

/// `estimator`, `pdf`, `nsamples`, and the parameters of all estimators and densities: the scene may have
/// those of one that the command line chooses. What the command line says wins, but what the scene says is
/// checked as well. Errors: SceneError for unknown names, with the nearest one, and for numbers out of range.
LayeredSettings ReadLayeredSettings(const MaterialArgs& args);

/// Path vertices for a `maxdepth` d: an entry, d events inside, and an exit.
inline int VerticesOfDepth(int d) { return std::min(d, kMaxPathVertices - 2) + 2; }

}  // namespace lacquer::layered
