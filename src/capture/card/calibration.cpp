#include "capture/card/calibration.h"

#include <ceres/ceres.h>
#include <ceres/normal_prior.h>
#include <ceres/rotation.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "capture/card/calibration_checks.h"
#include "capture/card/card.h"
#include "capture/card/tag_edges.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"
#include "pbrt/core/math.h"

namespace lacquer::capture {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kNumIntrinsics = 5, kNumPose = 6;  // f, cx, cy, k1, k2; rotation (axis times angle), position

/// The eight numbers that a tag is off by, as independent ones: for each edge, its middle and its turn. A
/// corner is where two fitted lines meet, so the ends of one line are off together: with points of variance v
/// at N places of the middle part s (kEdgeShare) of the edge, the mean of both has the variance v/N, half of
/// their difference 3 v/(N s^2), and both are not correlated. Corners taken for independent would count with
/// the wrong weights. Lenses bend edges: a line fitted to the middle part of a parabola lies 1 - s^2/3 of its
/// height from its chord.
struct TagResidual {
    TagResidual(const DetectedTag& tag, double size) : observed(tag.corners), card(TagCorners(tag.id, size)) {
        for (size_t i = 0; i < 4; ++i) {
            const Vector2d along = (observed[(i + 1) % 4] - observed[i]).normalized();
            normals[i] = {along.y(), -along.x()};
        }
    }

    template <class T>
    bool operator()(const T* intrinsics, const T* pose, T* residuals) const {
        std::array<std::array<T, 2>, 4> off, offMiddle;
        for (size_t i = 0; i < 4; ++i) {
            const size_t j = (i + 1) % 4;
            if (!Off(intrinsics, pose, card[i], observed[i], &off[i]) ||
                !Off(intrinsics, pose, 0.5 * (card[i] + card[j]), 0.5 * (observed[i] + observed[j]),
                     &offMiddle[i]))
                return false;
        }
        const double turn = kEdgeShare / std::sqrt(3.), chord = kEdgeShare * kEdgeShare / 3;
        for (size_t i = 0; i < 4; ++i) {
            const auto across = [&](const std::array<T, 2>& v) {
                return v[0] * normals[i].x() + v[1] * normals[i].y();
            };
            const T a = across(off[i]), b = across(off[(i + 1) % 4]);
            residuals[2 * i] = chord * 0.5 * (a + b) + (1 - chord) * across(offMiddle[i]);
            residuals[2 * i + 1] = turn * 0.5 * (a - b);
        }
        return true;
    }

    /// From where a point is in the photograph to where the camera should see it. False behind the camera.
    template <class T>
    static bool Off(const T* intrinsics, const T* pose, const Vector2d& point, const Vector2d& pixel,
                    std::array<T, 2>* off) {
        const T relative[3] = {point.x() - pose[3], point.y() - pose[4], -pose[5]};
        T p[3];
        ceres::AngleAxisRotatePoint(pose, relative, p);
        if (!(p[2] > T(0))) return false;
        T x = p[0] / p[2], y = p[1] / p[2];
        Distort(intrinsics[3], intrinsics[4], &x, &y);
        *off = {intrinsics[0] * x + intrinsics[1] - pixel.x(), intrinsics[0] * y + intrinsics[2] - pixel.y()};
        return true;
    }

    static ceres::CostFunction* Make(const DetectedTag& tag, double size) {
        return new ceres::AutoDiffCostFunction<TagResidual, 8, kNumIntrinsics, kNumPose>(
            new TagResidual(tag, size));
    }

    std::array<Vector2d, 4> observed, card, normals;
};

/// The least squares problem of all photographs: all residuals in units of pixels, with priors of the
/// intrinsics that are wide against what photographs tell, if they tell anything.
class Bundle {
  public:
    Bundle(std::span<const UsableTags> photographs, const CalibrationOptions& options)
        : options_(options), areIntrinsicsFree_(photographs.size() >= 3), rejected_(photographs.size()) {
        for (const UsableTags& p : photographs) tags_.push_back(p.tags);
        const double diagonal = std::hypot(options.resolution.x, options.resolution.y);
        // Metadata have whole millimetres of a camera that was asked for; lenses are corrected by a few per
        // cent. Where there are none: a guess as wide as cameras are, lest f runs away with views from
        // straight above.
        double focal = 0.8 * std::max(options.resolution.x, options.resolution.y), focalError = 0.5 * focal;
        if (options.focalOfMetadata) {
            focal = *options.focalOfMetadata;
            focalError = (areIntrinsicsFree_ ? 0.1 : 0.03) * focal;
        }
        if (options.focal) {
            focal = *options.focal;
            focalError = 0;
        }
        const double center = 0.02 * diagonal;
        prior_ = {focal, 0.5 * options.resolution.x, 0.5 * options.resolution.y, 0, 0};
        priorError_ = areIntrinsicsFree_ ? Five{focalError, center, center, 0.3, 0.3}
                                         : Five{focalError, center, center, 0.03, 0};
        intrinsics_ = prior_;
    }

    void Start(std::span<const UsableTags> photographs) {
        std::vector<Eigen::Matrix3d> homographies;
        for (const UsableTags& p : photographs) homographies.push_back(p.homography);
        if (!options_.focal && !options_.focalOfMetadata) {
            const double guess = prior_[0];
            const std::optional<double> found = FocalLengthOf(homographies, {prior_[1], prior_[2]}, guess);
            if (found && *found > 0.2 * guess && *found < 15 * guess) intrinsics_[0] = *found;
        }
        for (const Eigen::Matrix3d& h : homographies) {
            const CameraPose pose = PoseOf(h, CurrentIntrinsics());
            std::array<double, kNumPose>& numbers = poses_.emplace_back();
            ceres::RotationMatrixToAngleAxis(pose.rotation.data(), numbers.data());
            for (size_t i = 0; i < 3; ++i) numbers[3 + i] = pose.position[Eigen::Index(i)];
        }
    }

    /// Without a robust loss at first, since distortion may still be in all residuals; then with one, tags
    /// are left out that it has left far off, and what remains is an ordinary problem.
    void Solve() {
        Minimize(false);
        EstimateNoise();
        Minimize(true);
        RejectOutliers();
        for (int i = 0; i < 2; ++i) {  // priors count by the noise
            Minimize(false);
            EstimateNoise();
        }
    }

    bool IsUsable() const { return isUsable_ && std::isfinite(intrinsics_[0]) && intrinsics_[0] > 0; }
    Intrinsics CurrentIntrinsics() const {
        return {intrinsics_[0], intrinsics_[1], intrinsics_[2], intrinsics_[3], intrinsics_[4]};
    }
    CameraPose Pose(size_t i) const {
        CameraPose pose;
        ceres::AngleAxisToRotationMatrix(poses_[i].data(), pose.rotation.data());
        pose.position = Eigen::Map<const Vector3d>(poses_[i].data() + 3);
        return pose;
    }
    const std::vector<DetectedTag>& Tags(size_t i) const { return tags_[i]; }
    const std::vector<int>& Rejected(size_t i) const { return rejected_[i]; }

    /// Covariance of all numbers, intrinsics first. Where these were not estimated, what is not known of them
    /// is pushed through the estimate of the poses.
    MatrixXd Covariance() {
        const MatrixXd jacobian = Jacobian();
        const Eigen::Index count = jacobian.cols(), k = kNumIntrinsics;
        MatrixXd information = jacobian.transpose() * jacobian / (noise_ * noise_);
        MatrixXd covariance = MatrixXd::Zero(count, count);
        std::vector<Eigen::Index> free;
        for (Eigen::Index i = 0; i < count; ++i) {
            const double error = i < k ? priorError_[size_t(i)] : 1;
            if (i >= k || (areIntrinsicsFree_ && error > 0)) free.push_back(i);
            if (i < k && error > 0 && areIntrinsicsFree_) information(i, i) += 1 / (error * error);
        }
        const MatrixXd inverse = MatrixXd(information(free, free)).inverse();
        covariance(free, free) = inverse;
        if (areIntrinsicsFree_) return covariance;
        const Eigen::VectorXd known = Eigen::Map<const Eigen::VectorXd>(priorError_.data(), k).cwiseAbs2();
        const MatrixXd sensitivity = inverse * information.bottomLeftCorner(count - k, k);
        covariance.bottomRightCorner(count - k, count - k) +=
            sensitivity * known.asDiagonal() * sensitivity.transpose();
        covariance.topLeftCorner(k, k) = known.asDiagonal();
        return covariance;
    }

    /// Distance of corners from where they should be, root mean square.
    double Rms(const DetectedTag& tag, const CameraPose& pose) const {
        double sum = 0;
        const DetectedTag projected = ProjectTag(tag.id, pose);
        for (size_t c = 0; c < 4; ++c) sum += (projected.corners[c] - tag.corners[c]).squaredNorm() / 4;
        return std::sqrt(sum);
    }
    DetectedTag ProjectTag(int id, const CameraPose& pose) const {
        DetectedTag tag{id, {}};
        const auto corners = TagCorners(id, options_.size);
        for (size_t c = 0; c < 4; ++c)
            tag.corners[c] = ProjectPoint(CurrentIntrinsics(), pose, {corners[c].x(), corners[c].y(), 0});
        return tag;
    }

  private:
    using Five = std::array<double, kNumIntrinsics>;

    void AddTags(ceres::Problem* problem, bool isRobust) {
        for (size_t i = 0; i < poses_.size(); ++i)
            for (const DetectedTag& tag : tags_[i]) {
                // Eight residuals of one deviation each are usual; ten times as many begin to lose their
                // weight.
                ceres::LossFunction* loss = isRobust ? new ceres::CauchyLoss(9 * noise_) : nullptr;
                problem->AddResidualBlock(TagResidual::Make(tag, options_.size), loss, intrinsics_.data(),
                                          poses_[i].data());
            }
    }

    void FixIntrinsics(ceres::Problem* problem) {
        if (!areIntrinsicsFree_) {
            problem->SetParameterBlockConstant(intrinsics_.data());
            return;
        }
        // Ceres takes the ownership of what it is given. The weights are those of residuals in pixels.
        ceres::Vector mean = Eigen::Map<const ceres::Vector>(prior_.data(), kNumIntrinsics);
        ceres::Matrix weights = ceres::Matrix::Zero(kNumIntrinsics, kNumIntrinsics);
        for (size_t i = 0; i < kNumIntrinsics; ++i)
            if (priorError_[i] > 0) weights(Eigen::Index(i), Eigen::Index(i)) = noise_ / priorError_[i];
        problem->AddResidualBlock(new ceres::NormalPrior(weights, mean), nullptr, intrinsics_.data());
        if (options_.focal)
            problem->SetManifold(intrinsics_.data(), new ceres::SubsetManifold(kNumIntrinsics, {0}));
    }

    void Minimize(bool isRobust) {
        ceres::Problem problem;
        AddTags(&problem, isRobust);
        FixIntrinsics(&problem);
        ceres::Solver::Options options;
        options.linear_solver_type = ceres::DENSE_QR;
        options.logging_type = ceres::SILENT;
        options.max_num_iterations = 200;
        options.function_tolerance = 1e-12;
        options.parameter_tolerance = 1e-12;
        options.num_threads = 1;  // the same bits whatever the machine
        ceres::Solver::Summary summary;
        ceres::Solve(options, &problem, &summary);
        isUsable_ = summary.IsSolutionUsable();
    }

    MatrixXd Jacobian() {
        ceres::Problem problem;
        AddTags(&problem, false);
        ceres::Problem::EvaluateOptions options;
        options.parameter_blocks.push_back(intrinsics_.data());
        for (auto& pose : poses_) options.parameter_blocks.push_back(pose.data());
        ceres::CRSMatrix sparse;
        LACQUER_CHECK(problem.Evaluate(options, nullptr, nullptr, nullptr, &sparse));
        MatrixXd dense = MatrixXd::Zero(sparse.num_rows, sparse.num_cols);
        for (int row = 0; row < sparse.num_rows; ++row)
            for (int i = sparse.rows[size_t(row)]; i < sparse.rows[size_t(row) + 1]; ++i)
                dense(row, sparse.cols[size_t(i)]) = sparse.values[size_t(i)];
        return dense;
    }

    /// Standard deviation of residuals from their squares, for what is estimated of them.
    void EstimateNoise() {
        ceres::Problem problem;
        AddTags(&problem, false);
        double cost = 0;  // half of the squares
        LACQUER_CHECK(problem.Evaluate({}, &cost, nullptr, nullptr, nullptr));
        const double numEstimated =
            double(kNumPose * poses_.size()) + (areIntrinsicsFree_ ? kNumIntrinsics : 0);
        // Positions of edges are never known to less than some thousandths of a pixel.
        noise_ = std::max(0.003, std::sqrt(2 * cost / (problem.NumResiduals() - numEstimated)));
    }

    /// At most an eighth of a photograph's tags: if more are off, it is the card or the camera that is not as
    /// it should be, and nothing may hide it.
    void RejectOutliers() {
        std::vector<double> all;
        for (size_t i = 0; i < poses_.size(); ++i)
            for (const DetectedTag& tag : tags_[i]) all.push_back(Rms(tag, Pose(i)));
        auto middle = all.begin() + std::ptrdiff_t(all.size() / 2);
        std::nth_element(all.begin(), middle, all.end());
        const double limit = std::max(6 * *middle, 0.2);
        for (size_t i = 0; i < poses_.size(); ++i) {
            std::vector<DetectedTag> kept;
            std::vector<int> rejected;
            for (const DetectedTag& tag : tags_[i])
                if (Rms(tag, Pose(i)) > limit)
                    rejected.push_back(tag.id);
                else
                    kept.push_back(tag);
            if (rejected.size() > tags_[i].size() / 8 || !SurroundTheWindow(kept)) continue;
            tags_[i] = std::move(kept);
            rejected_[i] = std::move(rejected);
        }
    }

    const CalibrationOptions& options_;
    const bool areIntrinsicsFree_;
    Five prior_{}, priorError_{}, intrinsics_{};
    std::vector<std::array<double, kNumPose>> poses_;
    std::vector<std::vector<DetectedTag>> tags_;
    std::vector<std::vector<int>> rejected_;
    double noise_ = 0.1;  ///< of residuals [pixels]
    bool isUsable_ = true;
};

PhotographPose PoseResult(const Bundle& bundle, size_t i, const UsableTags& usable,
                          const MatrixXd& covariance) {
    PhotographPose result;
    result.pose = bundle.Pose(i);
    result.covariance = covariance.block<3, 3>(kNumIntrinsics + kNumPose * Eigen::Index(i) + 3,
                                               kNumIntrinsics + kNumPose * Eigen::Index(i) + 3);
    result.tags = bundle.Tags(i);
    result.rejected = usable.rejected;
    result.rejected.insert(result.rejected.end(), bundle.Rejected(i).begin(), bundle.Rejected(i).end());
    std::sort(result.rejected.begin(), result.rejected.end());
    double square = 0;
    for (const DetectedTag& tag : result.tags) {
        result.projected.push_back(bundle.ProjectTag(tag.id, result.pose));
        square += Sqr(bundle.Rms(tag, result.pose)) / double(result.tags.size());
    }
    result.rms = std::sqrt(square);
    return result;
}

}  // namespace

Calibration Calibrate(std::span<const CardPhotograph> photographs, const CalibrationOptions& options) {
    Calibration result;
    CheckCalibrationInput(photographs, options);
    const std::vector<UsableTags> usable = FindUsableTags(photographs, options.size, &result.warnings);
    Bundle bundle(usable, options);
    bundle.Start(usable);
    bundle.Solve();
    if (!bundle.IsUsable())
        throw SceneError(
            {photographs[0].name},
            "no camera fits the tags of the photographs; tilt it in other directions, or say its "
            "focal length");
    result.intrinsics = bundle.CurrentIntrinsics();
    const MatrixXd covariance = bundle.Covariance();
    result.focalError = std::sqrt(covariance(0, 0));
    double square = 0;
    for (size_t i = 0; i < photographs.size(); ++i) {
        result.photographs.push_back(PoseResult(bundle, i, usable[i], covariance));
        square += Sqr(result.photographs.back().rms) / double(photographs.size());
        if (const std::vector<int>& far = bundle.Rejected(i); !far.empty())
            result.warnings.push_back(
                fmt::format("{}: tags {} lie off from where the others say, and do not count",
                            photographs[i].name, ListOfIds(far)));
    }
    result.rms = std::sqrt(square);
    CheckCalibration(photographs, options, &result);
    return result;
}

}  // namespace lacquer::capture
