#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <compare>
#include <cstddef>
#include <initializer_list>
#include <iterator>
#include <stdexcept>
#include <utility>
#include <vector>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// Joint vectors of many readings, one after another: a million rows of six joints take 48 MB, as
/// vectors with room for kMaxJoints 144 MB. All have the same number of joints. It is used like a
/// std::vector<JointVector>, but a row is a view of its numbers: `auto` holds the view, and
/// `JointVector` a copy.
class JointRows {
 public:
  using value_type = JointVector;
  using Row = Eigen::Map<JointVector>;
  using ConstRow = Eigen::Map<const JointVector>;

  template <typename Rows, typename View>
  class Iterator {
   public:
    using iterator_category = std::random_access_iterator_tag;
    using value_type = JointVector;
    using difference_type = std::ptrdiff_t;
    using reference = View;
    using pointer = void;

    Iterator() = default;
    Iterator(Rows& rows, std::ptrdiff_t row) : rows_(&rows), row_(row) {}
    View operator*() const { return (*rows_)[row_]; }
    View operator[](std::ptrdiff_t k) const { return *(*this + k); }
    Iterator& operator++() { return *this += 1; }
    Iterator& operator--() { return *this += -1; }
    Iterator operator++(int) { return std::exchange(*this, *this + 1); }
    Iterator operator--(int) { return std::exchange(*this, *this - 1); }
    Iterator& operator+=(std::ptrdiff_t k) {
      row_ += k;
      return *this;
    }
    Iterator& operator-=(std::ptrdiff_t k) { return *this += -k; }
    friend Iterator operator+(Iterator a, std::ptrdiff_t k) { return a += k; }
    friend Iterator operator+(std::ptrdiff_t k, Iterator a) { return a += k; }
    friend Iterator operator-(Iterator a, std::ptrdiff_t k) { return a -= k; }
    friend std::ptrdiff_t operator-(const Iterator& a, const Iterator& b) {
      return a.row_ - b.row_;
    }
    bool operator==(const Iterator& other) const { return row_ == other.row_; }
    auto operator<=>(const Iterator& other) const { return row_ <=> other.row_; }

   private:
    Rows* rows_ = nullptr;
    std::ptrdiff_t row_ = 0;
  };

  JointRows() = default;
  JointRows(std::initializer_list<JointVector> rows) : JointRows(rows.begin(), rows.end()) {}
  JointRows(const std::vector<JointVector>& rows) : JointRows(rows.begin(), rows.end()) {}
  JointRows(size_t count, const JointVector& q) { resize(count, q); }
  template <std::input_iterator From>
  JointRows(From begin, From end) {
    for (; begin != end; ++begin) push_back(*begin);
  }

  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  Row operator[](size_t row) { return Row(numbers_.data() + row * joints_, joints_); }
  ConstRow operator[](size_t row) const {
    return ConstRow(numbers_.data() + row * joints_, joints_);
  }
  Row front() { return (*this)[0]; }
  ConstRow front() const { return (*this)[0]; }
  Row back() { return (*this)[size_ - 1]; }
  ConstRow back() const { return (*this)[size_ - 1]; }
  auto begin() { return Iterator<JointRows, Row>(*this, 0); }
  auto end() { return Iterator<JointRows, Row>(*this, size_); }
  auto begin() const { return Iterator<const JointRows, ConstRow>(*this, 0); }
  auto end() const { return Iterator<const JointRows, ConstRow>(*this, size_); }

  /// Throws std::invalid_argument if `q` has another number of joints than the rows before.
  void push_back(const JointVector& q) {
    if (empty()) joints_ = q.size();
    if (q.size() != joints_)
      throw std::invalid_argument("readings of one campaign have one number of joints");
    numbers_.insert(numbers_.end(), q.begin(), q.end());
    ++size_;
  }
  template <typename... Of>
  void emplace_back(const Of&... of) {
    push_back(JointVector(of...));
  }
  /// Reserves memory for so many rows; without effect before the first row, which sets the number
  /// of joints.
  void reserve(size_t rows) { numbers_.reserve(rows * joints_); }
  void resize(size_t count, const JointVector& q) {
    if (count < size_) numbers_.resize(count * joints_);
    size_ = std::min(size_, count);
    numbers_.reserve(count * q.size());  // growth would take twice the memory
    while (size_ < count) push_back(q);
  }
  void assign(size_t count, const JointVector& q) {
    clear();
    resize(count, q);
  }
  void clear() { *this = JointRows(); }
  bool operator==(const JointRows&) const = default;

 private:
  std::vector<double> numbers_;
  Eigen::Index joints_ = 0;
  size_t size_ = 0;
};

}  // namespace armtrue
