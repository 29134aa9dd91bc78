#include "layered/materials/stack_builder.h"

#include <fmt/format.h>

#include "pbrt/core/check.h"

namespace lacquer::layered {
namespace {

/// Stacks with frames of their own, inside of one another.
constexpr size_t kMaxNesting = 64;
constexpr int kMaxSamples = 1 << 20;

/// Reads the entries in order; what it throws names the material and the entry.
class StackReader {
  public:
    explicit StackReader(const MaterialArgs& args) : args_(args) {}

    StackEntries Read() {
        names_ = args_.params.GetStrings("stack");
        if (names_.empty())
            Fail(fmt::format("{} needs \"string stack\": the names of its layers, outermost first", Owner()));
        for (size_t i = 0; i < names_.size(); ++i) Add(i);
        if (isIncomplete_) return {};
        if (lastIsSlab_) FailAt(names_.size() - 1, "is a slab; expected an interface below the last slab");
        CheckOpacity();
        return std::move(entries_);
    }

  private:
    [[noreturn]] void Fail(const std::string& message) const { args_.params.Fail("stack", message); }
    [[noreturn]] void FailAt(size_t i, const std::string& problem) const {
        Fail(fmt::format("{}: entry {} of its stack, \"{}\", {}", Owner(), i + 1, Excerpt(names_[i]),
                         problem));
    }
    std::string Owner() const {
        return args_.name.empty() ? args_.params.Owner()
                                  : fmt::format("material \"{}\"", Excerpt(args_.name));
    }

    /// The material of entry i; null for the interface that is not there.
    const Material* Find(size_t i) const {
        const std::string& name = names_[i];
        const auto it = args_.named.find(name);
        if (it != args_.named.end()) return it->second->IsInvisible() ? nullptr : it->second;
        if (name.empty() || name == "interface") return nullptr;
        if (name == args_.name)
            FailAt(i, "is the material itself; expected a material that stands before it");
        std::vector<std::string> known{"interface"};
        for (const auto& [other, material] : args_.named) known.push_back(other);
        FailAt(i, fmt::format("is no material that stands before it{}", DidYouMean(name, known)));
    }

    void Add(size_t i) {
        const Material* material = Find(i);
        if (material && material->IsPlaceholder()) {
            isIncomplete_ = true;
            lastIsSlab_ = false;
        } else if (const auto* slab = dynamic_cast<const SlabMaterial*>(material)) {
            AddSlab(i, slab);
        } else if (const auto* stack = dynamic_cast<const LayeredMaterial*>(material)) {
            AddStack(i, *stack);
        } else {
            AddInterface(i, material);
        }
    }

    void AddSlab(size_t i, const SlabMaterial* slab) {
        if (i == 0) FailAt(i, "is a slab; expected an interface above the first slab");
        if (lastIsSlab_) FailAt(i, "is a slab below a slab; expected an interface between the two");
        if (!entries_.empty()) entries_.back().slab = slab;
        lastIsSlab_ = true;
    }

    void AddInterface(size_t i, const Material* material) {
        if (const auto* other = dynamic_cast<const NoStackBoundary*>(material))
            FailAt(i, other->WhyNoStackBoundary());
        Append(i, StackEntry(material));
    }

    void AddStack(size_t i, const LayeredMaterial& stack) {
        for (StackEntry entry : stack.Entries()) {
            if (stack.HasBump()) {
                entry.aroundInterface.insert(entry.aroundInterface.begin(), &stack);
                entry.aroundSlab.insert(entry.aroundSlab.begin(), &stack);
            }
            if (entry.aroundInterface.size() > kMaxNesting)
                FailAt(i, fmt::format("has more than {} stacks inside of one another", kMaxNesting));
            Append(i, std::move(entry));
        }
        // The slab below a stack is outside of it.
        entries_.back().aroundSlab.clear();
    }

    void Append(size_t i, StackEntry entry) {
        if (entries_.size() == kMaxStackInterfaces)
            FailAt(i, fmt::format("is beyond the limit of {} interfaces, those of stacks in it included",
                                  kMaxStackInterfaces));
        entries_.push_back(std::move(entry));
        nameOf_.push_back(i);
        lastIsSlab_ = false;
    }

    void CheckOpacity() const {
        for (size_t k = 0; k + 1 < entries_.size(); ++k) {
            const Material* interface = entries_[k].interface;
            if (interface && !interface->Transmits())
                FailAt(nameOf_[k], fmt::format("lets no light through, but \"{}\" lies below it; expected an "
                                               "opaque interface only as the last one",
                                               Excerpt(names_[nameOf_[k + 1]])));
        }
    }

    const MaterialArgs& args_;
    std::vector<std::string> names_;
    StackEntries entries_;
    std::vector<size_t> nameOf_;  ///< for each of entries_, the index of the name that brought it in
    bool lastIsSlab_ = false, isIncomplete_ = false;
};

/// The object of the name that is in force. The others are made as well, for the parameters that they know.
template <class Kind>
auto MakeStrategy(const MaterialArgs& args, const char* parameter, const char* fallback) {
    const std::string name = args.params.GetChoice(parameter, fallback, Registry<Kind>::Names());
    const std::string replacement = args.Override(parameter);
    const std::string& wanted = replacement.empty() ? name : replacement;
    decltype(Registry<Kind>::Find(name)(args.params)) chosen;
    for (const std::string& each : Registry<Kind>::Names())
        if (auto strategy = Registry<Kind>::Find(each)(args.params); each == wanted)
            chosen = std::move(strategy);
    LACQUER_CHECK(chosen || !replacement.empty());
    if (!chosen)
        throw SceneError({}, fmt::format("unknown {} \"{}\"{}", Kind::kKind, Excerpt(replacement),
                                         DidYouMean(replacement, Registry<Kind>::Names())));
    return chosen;
}

}  // namespace

StackEntries ReadStack(const MaterialArgs& args) { return StackReader(args).Read(); }

LayeredSettings ReadLayeredSettings(const MaterialArgs& args) {
    LayeredSettings settings;
    settings.estimator =
        MakeStrategy<LayeredEstimatorKind>(args, "estimator", LayeredEstimatorKind::kDefault);
    settings.pdf = MakeStrategy<LayeredPdfKind>(args, "pdf", LayeredPdfKind::kDefault);
    settings.options.estimator = settings.estimator.get();
    settings.options.pdf = settings.pdf.get();
    settings.options.numSamples = args.params.GetIntInRange("nsamples", 1, 1, kMaxSamples);
    return settings;
}

}  // namespace lacquer::layered
