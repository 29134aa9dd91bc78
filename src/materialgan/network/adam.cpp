#include "materialgan/network/adam.h"

#include <cmath>

namespace lacquer::materialgan {

Adam::Adam(std::vector<Tensor> parameters, AdamOptions options)
    : parameters_(std::move(parameters)), options_(options) {
    for (Tensor& parameter : parameters_) {
        parameter.requires_grad_();
        first_.push_back(torch::zeros_like(parameter));
        second_.push_back(torch::zeros_like(parameter));
    }
}

void Adam::Step(double rate) {
    const torch::NoGradGuard noGradients;
    ++steps_;
    const double t = double(steps_);
    const double scale1 = 1 - std::pow(options_.beta1, t), scale2 = 1 - std::pow(options_.beta2, t);
    for (size_t i = 0; i < parameters_.size(); ++i) {
        const Tensor& gradient = parameters_[i].grad();
        if (!gradient.defined()) continue;
        if (options_.isSignDescent) {
            parameters_[i].addcdiv_(gradient, gradient.abs() + options_.epsilon, -rate);
            continue;
        }
        first_[i].mul_(options_.beta1).add_(gradient, 1 - options_.beta1);
        second_[i].mul_(options_.beta2).addcmul_(gradient, gradient, 1 - options_.beta2);
        const Tensor deviation = (second_[i] / scale2).sqrt_().add_(options_.epsilon);
        parameters_[i].addcdiv_(first_[i], deviation, -rate / scale1);
    }
    ClearGradients();
}

double Adam::ClipGradients(double length) {
    const torch::NoGradGuard noGradients;
    double squares = 0;
    for (const Tensor& parameter : parameters_)
        if (parameter.grad().defined()) squares += parameter.grad().square().sum().item<double>();
    const double before = std::sqrt(squares);
    if (before > length)
        for (const Tensor& parameter : parameters_)
            if (parameter.grad().defined()) parameter.grad().mul_(length / before);
    return before;
}

void Adam::ClearGradients() {
    for (Tensor& parameter : parameters_) parameter.mutable_grad() = Tensor();
}

}  // namespace lacquer::materialgan
