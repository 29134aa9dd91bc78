// Material "layered": interfaces with slabs between them.
//
//   "string stack" []        required     names of earlier materials, outermost first: interfaces, with slabs
//                                         or nothing between them; "interface" is one that is not there
//   "string estimator"       auto         how f is estimated: see docs/layered.md
//   "string pdf"             approximate  how the density of sampling is estimated
//   "integer nsamples"       1            estimates that one evaluation averages
//   "integer maxdepth"       0            events inside a stack after which a path ends; 0: no limit
//   "float eta"              1            index below the last interface over index above the first
//   "bool twosided"          if opaque    seen from below, the stack is flipped
//   parameters of the estimator and of the pdf: see the files in estimators/ and pdfs/
//   "displacement", "normalmap", "rotation": of the stack as a whole, beside those of its interfaces
#include "layered/materials/stack_builder.h"

namespace lacquer::layered {
namespace {

std::unique_ptr<Material> CreateLayered(const MaterialArgs& args) {
    const Params& params = args.params;
    StackEntries entries = ReadStack(args);
    LayeredSettings settings = ReadLayeredSettings(args);
    const int maxDepth = params.GetIntInRange("maxdepth", 0, 0, std::numeric_limits<int>::max());
    if (maxDepth > 0) settings.options.maxVertices = VerticesOfDepth(maxDepth);
    if (params.GetOptionalFloat("eta")) settings.etaBelow = params.GetFloatInRange("eta", 1, 1e-3f, 1e3f);
    const Material* last = entries.empty() ? nullptr : entries.back().interface;
    settings.options.isTwoSided = params.GetBool("twosided", last && !last->Transmits());

    std::unique_ptr<Material> material;
    if (entries.empty())
        material = std::make_unique<PlaceholderMaterial>();
    else
        material = std::make_unique<LayeredMaterial>(std::move(entries), std::move(settings));
    material->ReadBump(params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "layered", CreateLayered, {.isLayered = true});

}  // namespace lacquer::layered
