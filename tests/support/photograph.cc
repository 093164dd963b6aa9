#include "photograph.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace armtrue_oracle {
namespace {

constexpr double kWall = 110, kBlack = 25, kWhite = 225;

std::vector<std::string> filled(int columns, int rows, char with) {
  return std::vector<std::string>(static_cast<size_t>(rows),
                                  std::string(static_cast<size_t>(columns), with));
}

void put_marker(Print& print, int column, int row, const std::string& marker, int bits) {
  for (int y = 0; y < bits + 2; ++y)
    for (int x = 0; x < bits + 2; ++x) {
      const bool is_border = x == 0 || y == 0 || x == bits + 1 || y == bits + 1;
      print.cells[static_cast<size_t>(row + y)][static_cast<size_t>(column + x)] =
          is_border ? '#' : marker[static_cast<size_t>((y - 1) * bits + x - 1)];
    }
}

int bits_of(const std::vector<std::string>& markers) {
  return static_cast<int>(std::lround(std::sqrt(static_cast<double>(markers.front().size()))));
}

double grey_at(const Print& print, double x, double y) {
  const double column = (x - print.left) / print.cell, row = (y - print.top) / print.cell;
  if (column < 0 || row < 0 || row >= static_cast<double>(print.cells.size()) ||
      column >= static_cast<double>(print.cells.front().size()))
    return kWall;
  const bool is_dark = print.cells[static_cast<size_t>(row)][static_cast<size_t>(column)] == '#';
  if (!print.disks || !is_dark) return is_dark ? kBlack : kWhite;
  const double dx = (column - std::floor(column) - 0.5) * print.cell,
               dy = (row - std::floor(row) - 0.5) * print.cell;
  return std::hypot(dx, dy) < print.radius ? kBlack : kWhite;
}

// The direction (x, y, 1) whose pixel this is, by Newton's steps with differences.
std::array<double, 2> ray_of(const Eye& eye, double u, double v, std::array<double, 2> start) {
  constexpr double kStep = 1e-6;
  for (int round = 0; round < 20; ++round) {
    const auto [x, y] = start;
    const auto here = pixel_of(eye, {x, y, 1});
    const double du = u - here[0], dv = v - here[1];
    if (std::hypot(du, dv) < 1e-6) break;
    const auto by_x = pixel_of(eye, {x + kStep, y, 1}), by_y = pixel_of(eye, {x, y + kStep, 1});
    const double a = (by_x[0] - here[0]) / kStep, b = (by_y[0] - here[0]) / kStep;
    const double c = (by_x[1] - here[1]) / kStep, d = (by_y[1] - here[1]) / kStep;
    const double det = a * d - b * c;
    start = {x + (d * du - b * dv) / det, y + (a * dv - c * du) / det};
  }
  return start;
}

// Weights of a normal distribution, those of the pixel beside included.
void blur(std::vector<double>& grey, int width, int height, double sigma) {
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> weight;
  double sum = 0;
  for (int k = -reach; k <= reach; ++k)
    sum += weight.emplace_back(std::exp(-k * k / (2 * sigma * sigma)));
  for (double& w : weight) w /= sum;
  const auto pass = [&](int step, int length, int lines, int stride) {
    std::vector<double> line(static_cast<size_t>(length));
    for (int l = 0; l < lines; ++l) {
      for (int i = 0; i < length; ++i) {
        double mean = 0;
        for (int k = -reach; k <= reach; ++k)
          mean += weight[static_cast<size_t>(k + reach)] *
                  grey[static_cast<size_t>(l * stride + std::clamp(i + k, 0, length - 1) * step)];
        line[static_cast<size_t>(i)] = mean;
      }
      for (int i = 0; i < length; ++i)
        grey[static_cast<size_t>(l * stride + i * step)] = line[static_cast<size_t>(i)];
    }
  };
  pass(1, width, height, width);
  pass(width, height, width, 1);
}

}  // namespace

Print checkerboard(int columns, int rows, double pitch) {
  Print print;
  print.cell = pitch;
  print.left = print.top = -2 * pitch;
  print.cells = filled(columns + 3, rows + 3, '.');
  for (int y = 1; y < rows + 2; ++y)
    for (int x = 1; x < columns + 2; ++x)
      if ((x + y) % 2 == 0) print.cells[static_cast<size_t>(y)][static_cast<size_t>(x)] = '#';
  return print;
}

Print charuco(int columns, int rows, double pitch, const std::vector<std::string>& markers,
              int cells_per_square, bool white_first) {
  const int bits = bits_of(markers), n = cells_per_square, margin = (n - bits - 2) / 2;
  Print print;
  print.cell = pitch / n;
  print.left = print.top = -2 * pitch;
  print.cells = filled((columns + 2) * n, (rows + 2) * n, '.');
  size_t next = 0;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const int left = (x + 1) * n, top = (y + 1) * n;
      if ((x + y) % 2 == (white_first ? 0 : 1)) {
        put_marker(print, left + margin, top + margin, markers[next++], bits);
        continue;
      }
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
          print.cells[static_cast<size_t>(top + i)][static_cast<size_t>(left + j)] = '#';
    }
  return print;
}

Print tags(int columns, int rows, double side, int cells_of_gap,
           const std::vector<std::string>& markers) {
  const int bits = bits_of(markers), step = bits + 2 + cells_of_gap;
  Print print;
  print.cell = side / (bits + 2);
  print.left = print.top = -cells_of_gap * print.cell;
  print.cells = filled(columns * step + cells_of_gap, rows * step + cells_of_gap, '.');
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      put_marker(print, cells_of_gap + x * step, cells_of_gap + y * step,
                 markers[static_cast<size_t>(y * columns + x)], bits);
  return print;
}

Print disks(int columns, int rows, double pitch, bool asymmetric) {
  Print print;
  print.cell = pitch;
  print.disks = true;
  print.radius = (asymmetric ? 0.45 : 0.3) * pitch;
  print.left = print.top = -1.5 * pitch;
  const int step = asymmetric ? 2 : 1;
  print.cells = filled(step * columns + 2, rows + 2, '.');
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x)
      print.cells[static_cast<size_t>(y + 1)]
                 [static_cast<size_t>(1 + step * x + (asymmetric ? y % 2 : 0))] = '#';
  return print;
}

Photographer::Photographer(const Eye& eye) : width_(eye.width), height_(eye.height) {
  for (int v = 0; v <= height_; ++v) {
    std::array<double, 2> ray{-eye.cx / eye.fx, (v - eye.cy) / eye.fy};
    for (int u = 0; u <= width_; ++u) rays_.push_back(ray = ray_of(eye, u - 0.5, v - 0.5, ray));
  }
}

std::string Photographer::photograph(const Print& print, const KDL::Frame& seen,
                                     const Exposure& exposure, Dice& dice) const {
  constexpr int kPlaces = 4;  // of a side of a pixel
  std::vector<double> grey;
  const KDL::Vector x = seen.M.UnitX(), y = seen.M.UnitY(), z = seen.M.UnitZ();
  const double depth = KDL::dot(z, seen.p), left = KDL::dot(x, seen.p), top = KDL::dot(y, seen.p);
  for (int v = 0; v < height_; ++v)
    for (int u = 0; u < width_; ++u) {
      const auto corner = static_cast<size_t>(v * (width_ + 1) + u);
      const auto &a = rays_[corner], &b = rays_[corner + 1];
      const auto &c = rays_[corner + static_cast<size_t>(width_) + 1],
                 &d = rays_[corner + static_cast<size_t>(width_) + 2];
      double sum = 0;
      for (int i = 0; i < kPlaces; ++i)
        for (int j = 0; j < kPlaces; ++j) {
          const double s = (i + 0.5) / kPlaces, t = (j + 0.5) / kPlaces;
          const KDL::Vector direction(
              (1 - t) * ((1 - s) * a[0] + s * b[0]) + t * ((1 - s) * c[0] + s * d[0]),
              (1 - t) * ((1 - s) * a[1] + s * b[1]) + t * ((1 - s) * c[1] + s * d[1]), 1);
          const double along = depth / KDL::dot(z, direction);
          sum += along > 0 ? grey_at(print, along * KDL::dot(x, direction) - left,
                                     along * KDL::dot(y, direction) - top)
                           : kWall;
        }
      grey.push_back(sum / (kPlaces * kPlaces));
    }
  if (exposure.blur_px > 0) blur(grey, width_, height_, exposure.blur_px);
  std::string file = "P5\n" + std::to_string(width_) + " " + std::to_string(height_) + "\n255\n";
  for (double value : grey)
    file += static_cast<char>(static_cast<std::uint8_t>(
        std::clamp(std::lround(value + exposure.noise_grey * dice.normal()), 0L, 255L)));
  return file;
}

}  // namespace armtrue_oracle
