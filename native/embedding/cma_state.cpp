// The optimiser's whole state as numbers, and back.
#include "common/error.h"
#include "embedding/cma_es.h"

namespace transformables {
namespace {

/// Writes numbers of every kind as doubles; a Reader of the same calls gets them back.
struct Writer {
  std::vector<double> out;
  static constexpr bool kReads = false;
  void operator()(double& v) { out.push_back(v); }
};

struct Reader {
  const std::vector<double>& in;
  std::size_t at = 0;
  static constexpr bool kReads = true;
  void operator()(double& v) {
    if (at >= in.size()) throw InvalidInput("saved optimiser state is cut short: start the search anew");
    v = in[at++];
  }
};

template <class Archive, class Integer>
void whole(Archive& archive, Integer& value) {
  double v = double(value);
  archive(v);
  value = Integer(v);
}

template <class Archive>
void bits(Archive& archive, std::uint64_t& value) {  // as two halves: a double holds 53 bits
  double high = double(value >> 32), low = double(value & 0xffffffffu);
  archive(high);
  archive(low);
  value = (std::uint64_t(high) << 32) | std::uint64_t(low);
}

template <class Archive, class Matrix>
void matrix(Archive& archive, Matrix& m) {
  Eigen::Index rows = m.rows(), cols = m.cols();
  whole(archive, rows);
  whole(archive, cols);
  if (rows < 0 || cols < 0 || rows > 100000 || cols > 100000)
    throw InvalidInput("saved optimiser state is damaged: start the search anew");
  m.resize(rows, cols);
  for (Eigen::Index i = 0; i < m.size(); ++i) archive(m.data()[i]);
}

template <class Archive>
void history(Archive& archive, std::deque<double>& h) {
  std::size_t size = h.size();
  whole(archive, size);
  if (size > 100000) throw InvalidInput("saved optimiser state is damaged: start the search anew");
  h.resize(size);
  for (double& v : h) archive(v);
}

}  // namespace

template <class Archive>
void CmaEs::visit(Archive& archive) {
  whole(archive, population_);
  bits(archive, options_.seed);
  whole(archive, options_.population);
  whole(archive, options_.active);
  whole(archive, options_.diagonal);
  archive(options_.tol_fun);
  archive(options_.tol_x);
  archive(options_.largest_condition);
  for (Eigen::VectorXd* v : {&mean_, &path_sigma_, &path_c_, &axis_lengths_, &best_}) matrix(archive, *v);
  for (Eigen::MatrixXd* m : {&covariance_, &axes_, &samples_, &steps_}) matrix(archive, *m);
  for (double* v : {&sigma_, &first_sigma_, &best_value_, &random_.spare}) archive(*v);
  whole(archive, generation_);
  whole(archive, decomposed_at_);
  for (auto& word : random_.state) bits(archive, word);
  whole(archive, random_.has_spare);
  whole(archive, asked_);
  history(archive, best_history_);
  history(archive, median_history_);
  int stop = int(stop_);
  whole(archive, stop);
  stop_ = Stop(stop);
}

std::vector<double> CmaEs::save() const {
  Writer writer;
  CmaEs copy = *this;
  copy.visit(writer);
  return std::move(writer.out);
}

CmaEs CmaEs::restored(const std::vector<double>& saved) {
  Reader reader{saved};
  CmaEs result;
  result.visit(reader);
  const Eigen::Index n = result.mean_.size();
  if (reader.at != saved.size() || n == 0 || result.population_ < 4 || result.covariance_.rows() != n ||
      result.samples_.cols() != result.population_)
    throw InvalidInput("saved optimiser state is damaged: start the search anew");
  result.set_constants();
  return result;
}

}  // namespace transformables
