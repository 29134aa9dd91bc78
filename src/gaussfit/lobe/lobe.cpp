#include "gaussfit/lobe/lobe.h"

#include <memory>
#include <string>

#include "gaussfit/lobe/lobe_table.h"
#include "pbrt/core/check.h"
#include "pbrt/core/embedded.h"

namespace lacquer::gaussfit {

namespace {

constexpr size_t kNumDistributions = 8, kNumEvents = 3;

/// All tables of the executable, by distribution and event.
class EmbeddedLobes {
  public:
    EmbeddedLobes() {
        for (const LobeModel& model : LobeModels()) {
            const std::string name = std::string("lobes/") + model.name + ".txt";
            // A model whose first fit has yet to be made.
            if (!HasEmbeddedData(name)) continue;
            At(model.distribution, model.event) =
                std::make_unique<LobeTable>(LobeTable::Parse(EmbeddedData(name), name));
        }
    }
    const LobeTable* Find(MicrofacetModel distribution, LobeEvent event) const {
        return tables_[Index(distribution, event)].get();
    }

  private:
    static size_t Index(MicrofacetModel distribution, LobeEvent event) {
        return size_t(distribution) * kNumEvents + size_t(event);
    }
    std::unique_ptr<LobeTable>& At(MicrofacetModel distribution, LobeEvent event) {
        LACQUER_CHECK(size_t(distribution) < kNumDistributions);
        return tables_[Index(distribution, event)];
    }
    std::array<std::unique_ptr<LobeTable>, kNumDistributions * kNumEvents> tables_;
};

}  // namespace

const LobeTable* EmbeddedLobeTable(MicrofacetModel distribution, LobeEvent event) {
    static const EmbeddedLobes lobes;
    return lobes.Find(distribution, event);
}

bool FindLobe(const MicrofacetSurface& surface, LobeEvent event, float eta, Vec3 w, GaussianMixture* lobe) {
    if (surface.alphaX != surface.alphaY) return false;
    const LobeTable* table = EmbeddedLobeTable(surface.model, event);
    return table && table->Find(surface.alphaX, eta, w, lobe);
}

}  // namespace lacquer::gaussfit
