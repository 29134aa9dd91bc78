// Tables of fitted lobes: evaluation, and the files that hold them. docs/gaussfit.md describes the format.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gaussfit/lobe/lobe_models.h"
#include "gaussfit/lobe/lobe_shape.h"

namespace lacquer::gaussfit {

/// Degrees of the Bernstein polynomials in the coordinates of eta (0 for reflections), alpha and the angle.
inline constexpr int kLobeEtaDegree = 3, kLobeAlphaDegree = 4, kLobeThetaDegree = 5;

/// The factors to a LobeBasis over a part of the alphas, as polynomials in three variables: a tensor product
/// of Bernstein polynomials, sum B_i(eta) B_j(alpha) B_k(theta) c_ijk. Their values lie between the smallest
/// and the largest control value c_ijk, so positive control values make positive factors; that is the reason
/// for the Bernstein basis in [Xia et al. 2020] eq. 19, here for all three variables.
struct LobePatch {
    /// What there are factors for, for each component of the mixture. Mean, L11 and L22 are relative to the
    /// LobeBasis; the weight is the component's own, and 1 minus the others' for the last one (where the
    /// field is not looked at).
    enum Field { Mean, L11, L22, Weight };
    static constexpr int kFields = 4;

    double alphaMin = 0, alphaMax = 1;
    bool anglesBySpread = false;
    std::vector<float> control;  ///< [eta][alpha][theta][component][field]
};

/// The table of one model.
class LobeTable {
  public:
    static constexpr int kVersion = 1;
    static constexpr int kMaxComponents = 2;

    /// What a table holds; a plain record, so that fits can fill it in.
    struct Content {
        const LobeModel* model = nullptr;
        double etaMin = 1, etaMax = 1;   ///< larger index over smaller one; equal for reflections
        double grazingCosineMin = 0;     ///< smallest LobeBasis::grazingCosine that was fitted
        std::vector<LobePatch> patches;  ///< in ascending order of alpha, without gaps
        std::vector<std::pair<std::string, std::string>> options;  ///< of the fit, for the reader

        int EtaDegree() const { return model->Transmits() ? kLobeEtaDegree : 0; }
        int NumControlPoints() const {
            return (EtaDegree() + 1) * (kLobeAlphaDegree + 1) * (kLobeThetaDegree + 1);
        }
        int FieldsPerPoint() const { return model->numComponents * LobePatch::kFields; }
        LobeDomain DomainOf(const LobePatch& patch) const {
            return {patch.alphaMin, patch.alphaMax, etaMin, etaMax, grazingCosineMin, patch.anglesBySpread};
        }
    };

    /// Errors: FileError with `path` if the content makes no sense (see Parse).
    LobeTable(Content content, const std::string& path);

    /// Reads a file's text. Errors: FileError with `path`, and a message of its own for what is no table,
    /// another version, truncated, damaged (checksum), an unknown model, and values out of their ranges.
    static LobeTable Parse(std::string_view text, const std::string& path);
    /// The text of a file, which Parse() turns into the same table, bit by bit.
    std::string ToText() const;

    const Content& Get() const { return content_; }
    /// True for slices that lie in the table's ranges.
    bool Reaches(const LobeQuery<float>& query) const;
    /// The lobe for a w in the plane y = 0 with x/z >= 0; see FindLobe() for what it is. False where the
    /// table does not reach.
    bool Find(const LobeQuery<float>& query, std::array<LobeShape<float>, kMaxComponents>* shapes,
              std::array<float, kMaxComponents>* weights) const;
    /// The lobe for any w: see FindLobe().
    bool Find(float alpha, float eta, Vec3 w, GaussianMixture* lobe) const;

  private:
    Content content_;
    std::vector<LobeMap<float>> maps_;  // of the patches
    float alphaMin_ = 0, alphaMax_ = 0, etaMin_ = 1, etaMax_ = 1, grazingCosineMin_ = 0;
};

/// The table that the executable holds for a model, parsed at the first call; null if it has none.
/// Errors: FileError for a broken one, at each call.
const LobeTable* EmbeddedLobeTable(MicrofacetModel distribution, LobeEvent event);

}  // namespace lacquer::gaussfit
