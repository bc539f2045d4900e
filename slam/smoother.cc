#include "slam/smoother.h"

#include <algorithm>
#include <iterator>

namespace slam {
namespace {

constexpr int kPose = 7;  // parameters of position and orientation

enum Kind { kChange, kAppend, kUpdate, kEndOfStep };

/// Reads the values of a step from the last to the first.
struct Backwards {
  const float *begin, *end;

  int number() { return static_cast<int>(*--end); }
  Eigen::MatrixXd matrix(int rows, int columns) {
    end -= rows * columns;
    return Eigen::Map<const Eigen::MatrixXf>(end, rows, columns).cast<double>();
  }
};

void undo_change(Kind kind, Backwards& values, Eigen::VectorXd& lambda) {
  const int at = values.number(), rows = values.number(), columns = values.number();
  const Eigen::VectorXd after = lambda,
                        changed = values.matrix(rows, columns).transpose() * after.segment(at, rows);
  const Eigen::Index rest = after.size() - at - rows;
  if (kind == kAppend) {
    lambda.conservativeResize(at);
    lambda.head(columns) += changed;
  } else {
    lambda.resize(at + columns + rest);
    lambda << after.head(at), changed, after.tail(rest);
  }
}

void undo_update(Backwards& values, Eigen::VectorXd& lambda) {
  const int rows = values.number(), blocks = values.number();
  const Eigen::MatrixXd L = values.matrix(rows, rows);
  Eigen::VectorXd y = values.matrix(rows, 1);
  y -= values.matrix(static_cast<int>(lambda.size()), rows).transpose() * lambda;
  L.triangularView<Eigen::Lower>().transpose().solveInPlace(y);
  lambda.head<kRobot>() += values.matrix(rows, kRobot).transpose() * y;
  for (int i = 0; i < blocks; ++i) {
    const int row = values.number(), at = values.number(), count = values.number(), columns = values.number();
    lambda.segment(at, columns) += values.matrix(count, columns).transpose() * y.segment(row, count);
  }
}

}  // namespace

Smoother::Smoother() : file_(std::tmpfile()), written_(file_ != nullptr) {}

void Smoother::put(const Eigen::Ref<const Eigen::MatrixXd>& M) {
  const std::size_t at = step_.size();
  step_.resize(at + static_cast<std::size_t>(M.size()));
  Eigen::Map<Eigen::MatrixXf>(step_.data() + at, M.rows(), M.cols()) = M.cast<float>();
}

/// Writes numbers so that they are read in this order.
void Smoother::put(std::initializer_list<Eigen::Index> numbers) {
  for (auto number = std::rbegin(numbers); number != std::rend(numbers); ++number)
    step_.push_back(static_cast<float>(*number));
}

void Smoother::change(int at, const Eigen::Ref<const Eigen::MatrixXd>& J) {
  put(J);
  put({kChange, at, J.rows(), J.cols()});
}

void Smoother::append(int at, const Eigen::Ref<const Eigen::MatrixXd>& J) {
  put(J);
  put({kAppend, at, J.rows(), J.cols()});
}

void Smoother::update(const StackedMeasurement& stacked, const Whitening& whitening,
                      const Eigen::Ref<const Eigen::MatrixXd>& W) {
  for (const StackedMeasurement::Block& block : stacked.blocks) {
    put(block.H);
    put({stacked.first_row[block.measurement], block.at, block.H.rows(), block.H.cols()});
  }
  put(stacked.H_robot());
  put(W);
  put(whitening.innovation());
  put(whitening.L());
  put({kUpdate, stacked.rows, static_cast<Eigen::Index>(stacked.blocks.size())});
}

void Smoother::end_step(Stamp t, const State& state) {
  size_ = state.size;
  Eigen::MatrixXd P(size_, kPose);
  P << state.marginal<kPose>(0), state.storage_P.block(kPose, 0, size_ - kPose, kPose);
  put(P);
  put({kEndOfStep});
  const std::size_t at = poses_.empty() ? 0 : poses_.back().at + poses_.back().values;
  poses_.push_back({t, state.x().head<kPose>(), at, step_.size()});
  written_ = written_ && std::fwrite(step_.data(), sizeof(float), step_.size(), file_.get()) == step_.size();
  step_.clear();
}

std::optional<std::vector<SmoothedPose>> Smoother::smoothed() {
  std::vector<SmoothedPose> smoothed;
  Eigen::VectorXd lambda = Eigen::VectorXd::Zero(size_);
  for (auto pose = poses_.rbegin(); pose != poses_.rend(); ++pose) {
    step_.resize(pose->values);
    if (!written_ || std::fseek(file_.get(), static_cast<long>(pose->at * sizeof(float)), SEEK_SET) != 0 ||
        std::fread(step_.data(), sizeof(float), step_.size(), file_.get()) != step_.size())
      return std::nullopt;
    Backwards values{step_.data(), step_.data() + step_.size()};
    while (values.end != values.begin) {
      const auto kind = static_cast<Kind>(values.number());
      if (kind == kEndOfStep)
        pose->x += values.matrix(static_cast<int>(lambda.size()), kPose).transpose() * lambda;
      else if (kind == kUpdate)
        undo_update(values, lambda);
      else
        undo_change(kind, values, lambda);
    }
    State state;
    state.storage_x.head<kPose>() = pose->x;
    state.storage_x.segment<4>(kOrientation).normalize();
    smoothed.push_back({pose->t, state.X_WC()});
  }
  std::ranges::reverse(smoothed);
  return smoothed;
}

}  // namespace slam
