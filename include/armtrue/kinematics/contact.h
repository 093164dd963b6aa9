#pragma once

#include <Eigen/Core>

#include "armtrue/kinematics/chain.h"

namespace armtrue {

/// The pixel of a point at `u` in the axes of a camera [px], and its derivatives.
struct PixelReading {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();  ///< [px/m]
  Eigen::Matrix<double, 2, kIntrinsics> by_intrinsics =
      Eigen::Matrix<double, 2, kIntrinsics>::Zero();
};

/// OpenCV's models of a lens, whose names these are. With x = u_x / u_z, y = u_y / u_z,
/// r^2 = x^2 + y^2:
///     pixel    (fx x' + cx, fy y' + cy)
///     pinhole  x' = x g + 2 p1 x y + p2 (r^2 + 2 x^2),  y' = y g + p1 (r^2 + 2 y^2) + 2 p2 x y,
///              g = 1 + k1 r^2 + k2 r^4 + k3 r^6  (Brown 1971)
///     fisheye  x' = x d / r,  y' = y d / r,  d = a (1 + k1 a^2 + k2 a^4 + k3 a^6 + k4 a^8),
///              a = atan(r)  (Kannala, Brandt 2006)
/// A point behind the camera, or less than 1 mm before it, has no image; it is projected as if it
/// were 1 mm before it, which no reading resembles.
PixelReading project(Lens lens, const Intrinsics& intrinsics, const Eigen::Vector3d& u);

/// Whether the image shows a point at `u` [m], in the axes of the camera: 10 mm or more before it,
/// `margin` [px] or more inside the edges, and where the pixel still moves outwards with the point
/// (where a distortion turns back, a point far outside would come in again). An image whose size is
/// not stated has its centre at the principal point: 2 (cx, cy) + 1 px.
bool is_in_image(const Contact& camera, const Eigen::Vector3d& u, double margin);

/// The touched part of a contact, in its axes: of an artefact the part `point`, which other kinds
/// ignore.
const ArtefactPoint& touched_part(const Contact& contact, int point);

/// Whether a touch of it reads three coordinates, not one distance.
inline bool reads_point(const Contact& contact, int point) {
  return touched_part(contact, point).kind == ContactKind::point;
}

/// One number that a touch reads, and its derivative by the touching point.
struct TouchReading {
  double value = 0;
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// The reading f(u) of ContactKind for a touch at `u`, in the axes of the contact [m]. `point`:
/// index into the points of an artefact. `axis`: the coordinate, 0 to 2; ignored for a plane or a
/// sphere.
TouchReading touch_reading(const Contact& contact, int point, int axis, const Eigen::Vector3d& u);

/// What a beam reads, in the axes of the contact.
struct BeamReading {
  double value = 0;                   ///< from the beam's origin to the plane, along it [m]
  Eigen::Vector3d hit{0, 0, 0};       ///< where it ends [m]
  Eigen::Vector3d gradient{0, 0, 0};  ///< derivative of the value by a shift of the beam
};

/// Sine of the least angle between a beam and a plane at which the beam reads something.
inline constexpr double kGrazing = 0.02;

/// The reading of a beam from `origin` [m] in the unit direction `along`, both in the axes of the
/// contact, on a plane or a face. With the plane n . u = h and c = n . along
///     value = (h - n . origin) / c,   gradient = -n / c.
/// Nearer to the plane than kGrazing, c counts as +-kGrazing: no reading resembles it.
BeamReading beam_reading(const Contact& contact, int point, const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& along);

}  // namespace armtrue
