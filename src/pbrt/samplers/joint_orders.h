// Orders of the Sobol points by which several pairs of dimensions are well distributed together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lacquer {

/// The first two dimensions of the Sobol sequence are a (0,2)-sequence in base 2: of every aligned block of
/// 2^m points, one is in each elementary interval of area 2^-m. That stays so if the points of each block are
/// taken in another order, and an order that is linear over GF(2), with an upper triangular matrix, has each
/// block for itself. Samplers take such a pair for every two dimensions of a path, each in an order of its
/// own. If that is random, as usual, pairs know nothing of each other. The orders here were found by search
/// (bench/sobol_orders.cpp), so that there is little noise in what depends on one dimension of one pair and
/// one of another: in the mean over levels 0.5 of that of independent points for 64 of them, and 0.2 for 256,
/// but 1.2 for 16, among which there are too few digits. What is smooth gains more: of a product of three
/// dimensions zsobol has 0.06 of the error of random orders with 64 points. An edge across two pairs has
/// noise of all levels: 1.1, 0.6 and 1.4 with 16, 64 and 256.
class JointOrders {
  public:
    static constexpr int kCount = 9, kBits = 12;
    /// Those of a path that they are for (bench/sobol_orders.cpp says what they are); others go by
    /// themselves.
    static constexpr std::array<int, kCount> kDimensions{0, 2, 4, 6, 7, 8, 9, 10, 11};

    /// One of them: indices to indices. Bits from kBits on stay.
    class Order {
      public:
        uint32_t operator()(uint32_t index) const {
            return (index & ~uint32_t((1 << kBits) - 1)) |
                   uint32_t(low_[index & (kLow - 1)] ^ high_[index / kLow % kHigh]);
        }

      private:
        friend class JointOrders;
        static constexpr uint32_t kLow = 256, kHigh = (1 << kBits) / kLow;
        std::array<uint16_t, kLow> low_{};
        std::array<uint16_t, kHigh> high_{};
    };

    /// Made by the first call.
    static const JointOrders& Get();
    const Order& Of(int i) const { return orders_[size_t(i)]; }

  private:
    JointOrders();
    std::array<Order, kCount> orders_;
};

}  // namespace lacquer
