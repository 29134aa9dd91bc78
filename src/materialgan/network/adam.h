// Gradient descent with moments, whose whole state can be stored.
#pragma once

#include "materialgan/network/tensors.h"

namespace lacquer::materialgan {

struct AdamOptions {
    double beta1 = 0.9, beta2 = 0.999, epsilon = 1e-8;
    /// Moments that begin anew at every step: the step is the rate in the direction of the sign, as in the
    /// programs of [Guo et al. 2020b].
    bool isSignDescent = false;
};

/// [Kingma and Ba 2015]. The order of the parameters counts for the state, not their names.
class Adam {
  public:
    explicit Adam(std::vector<Tensor> parameters, AdamOptions options = {});

    /// One step with the parameters' gradients, which are cleared; parameters without one stay.
    void Step(double rate);
    /// Makes the gradients' length over all parameters at most `length`. @return the length before
    double ClipGradients(double length);
    void ClearGradients();

    const std::vector<Tensor>& Parameters() const { return parameters_; }
    /// Both moments of each parameter, and the number of steps, to store and to set.
    const std::vector<Tensor>& FirstMoments() const { return first_; }
    const std::vector<Tensor>& SecondMoments() const { return second_; }
    std::vector<Tensor>& FirstMoments() { return first_; }
    std::vector<Tensor>& SecondMoments() { return second_; }
    int64_t NumSteps() const { return steps_; }
    void SetNumSteps(int64_t steps) { steps_ = steps; }

  private:
    std::vector<Tensor> parameters_, first_, second_;
    AdamOptions options_;
    int64_t steps_ = 0;
};

}  // namespace lacquer::materialgan
