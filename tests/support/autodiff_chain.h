#pragma once

// The chain written once more, with 4x4 matrices of any scalar, to differentiate automatically.

#include <Eigen/Core>
#include <cmath>
#include <string>

namespace armtrue_oracle {

template <typename T>
using Transform = Eigen::Matrix<T, 4, 4>;

template <typename T>
Transform<T> turn(int axis, const T& angle) {
  using std::cos;
  using std::sin;
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  Transform<T> m = Transform<T>::Identity();
  m(i, i) = cos(angle);
  m(j, j) = cos(angle);
  m(i, j) = -sin(angle);
  m(j, i) = sin(angle);
  return m;
}

template <typename T>
Transform<T> shift(const T& x, const T& y, const T& z) {
  Transform<T> m = Transform<T>::Identity();
  m(0, 3) = x;
  m(1, 3) = y;
  m(2, 3) = z;
  return m;
}

/// R_A from the measured frame. `kinds` has a letter for each link, R (turns), P (slides) or F
/// (fixed). `p` are its 12 + 5 links parameters: base and tool as small twists applied to `base`
/// and `tool` (translation added, rotation vector to first order on the left), links alpha d theta
/// r beta. `q` and `sign` have an entry for each driven link.
template <typename T>
Transform<T> chain(const T* p, const double* q, const double* sign, const Eigen::Matrix4d& base,
                   const Eigen::Matrix4d& tool, const std::string& kinds = "RRRRRRF") {
  const auto moved = [](const T* twist, const Eigen::Matrix4d& pose) {
    Transform<T> m = pose.cast<T>();
    const Transform<T> rotation =
        turn<T>(0, twist[3]) * turn<T>(1, twist[4]) * turn<T>(2, twist[5]);
    m.template topLeftCorner<3, 3>() =
        (rotation.template topLeftCorner<3, 3>() * pose.topLeftCorner<3, 3>().cast<T>()).eval();
    for (int i = 0; i < 3; ++i) m(i, 3) += twist[i];
    return m;
  };
  Transform<T> result = moved(p, base);
  const T* link = p + 6;
  for (const char kind : kinds) {
    T theta = link[2], r = link[3];
    if (kind == 'R') theta += *sign++ * *q++;
    if (kind == 'P') r += *sign++ * *q++;
    result = result * turn<T>(1, link[4]) * turn<T>(0, link[0]) * shift<T>(link[1], T(0), T(0)) *
             turn<T>(2, theta) * shift<T>(T(0), T(0), r);
    link += 5;
  }
  return result * moved(link, tool);
}

}  // namespace armtrue_oracle
