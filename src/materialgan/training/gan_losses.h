// What generator and discriminator minimise against each other, and how both are regularised.
#pragma once

#include "materialgan/network/stylegan.h"
#include "materialgan/training/discriminator.h"

namespace lacquer::materialgan {

/// The non-saturating logistic losses [Goodfellow et al. 2014], means over a batch of the discriminator's
/// numbers.
Tensor DiscriminatorLoss(const Tensor& ofReal, const Tensor& ofFake);
Tensor GeneratorLoss(const Tensor& ofFake);

/// R1 [Mescheder et al. 2018], without its weight gamma: half the squared length of the derivative by the
/// image, the mean over real images. Has derivatives by the discriminator's parameters.
Tensor GradientPenalty(const Discriminator& discriminator, const Tensor& real);

/// [Karras et al. 2020], eq. 4: lengths of J^T y for each image, where J is the derivative of the image by w
/// and y normal numbers. Has derivatives by the generator's parameters.
/// @param w  B x latentSize @return  B
Tensor PathLengths(const StyleGenerator& generator, const Tensor& w, torch::Generator random);
/// Of the squares of what lengths are off their mean, ln 2 / (r^2 (ln r - ln 2)) for a resolution r
/// [Karras et al. 2020], appendix B.
double PathLengthWeight(int resolution);

/// w+ of normal numbers; of nine in ten images layers from a random one on are of a second material, "style
/// mixing" [Karras et al. 2019, sec. 3.1]. B x NumColumns() x latentSize.
Tensor MixedStyles(const StyleGenerator& generator, int64_t batch, torch::Generator random);

}  // namespace lacquer::materialgan
