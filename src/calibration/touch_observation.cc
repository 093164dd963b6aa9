#include <stdexcept>

#include "armtrue/calibration/observation.h"
#include "armtrue/kinematics/contact.h"

namespace armtrue {

void ObservationModel::require_placed(const Contact& contact) const {
  if (is_of_images(contact.kind) && !contact.is_placed)
    throw std::invalid_argument(
        campaign_.source + ": the robot file does not say where '" + contact.name +
        "' is; calibrate the robot on images, with auto or base and tool among what is identified, "
        "or state its place under 'cameras' or 'boards'");
  if (!contact.is_placed)
    throw std::invalid_argument(
        campaign_.source + ": the robot file does not say where the contact '" + contact.name +
        "' is; calibrate the robot on readings that touch it, with auto or base among what is "
        "identified, or state its place under 'contacts'");
}

// Throws unless the contact has a place and the touch the axis that its kind needs.
void ObservationModel::require_bound(const Touch& touch) const {
  const ContactPoint& which = contacts_[touch.contact];
  const Contact& contact = robot_.chain.contacts[which.contact];
  require_placed(contact);
  if (which.board >= 0) return require_placed(robot_.chain.contacts[which.board]);
  if (reads_point(contact.kind) != (touch.axis >= 0))
    throw std::invalid_argument(campaign_.source + ": the touches of '" + contact.name +
                                "' are not those of bind_touches()");
}

// No instrument has a part in a touch, nor has its scale.
void ObservationModel::At::predict_touch(int row, const Eigen::VectorXd& offset,
                                         Prediction& predicted) const {
  const Touch touch = model_.campaign_.touch[row];
  const ContactPoint which = model_.contacts_[touch.contact];
  const Contact& contact = robot_.chain.contacts[which.contact];
  Pose place = model_.common_from_own_ * contact.place;
  double growth = 0;  // of the radius
  if (offset.size() > 0) {
    const int first = first_contact_parameter(robot_.chain) + kParametersOfContact * which.contact;
    place = place * Pose{rotation_exp(offset.segment<3>(first + 3)), offset.segment<3>(first)};
    growth = offset[first + 6];
  }
  predicted.scale = 1.0;
  predicted.in_contact =
      place.rotation.transpose() * (predicted.frame.translation - place.translation);
  const TouchReading reading =
      touch_reading(contact, which.point, touch.axis, predicted.in_contact);
  predicted.gradient = reading.gradient;
  predicted.direction = place.rotation * predicted.gradient;
  predicted.position = {reading.value - growth, 0, 0};
}

// The derivative of the reading of a touch by a parameter of a contact.
double ObservationModel::At::touch_column(int row, int parameter,
                                          const Prediction& predicted) const {
  const int k = parameter - first_contact_parameter(robot_.chain);
  const int contact = k / kParametersOfContact, which = k % kParametersOfContact;
  if (contact != model_.contacts_[model_.campaign_.touch[row].contact].contact) return 0;
  if (which == 6) return robot_.chain.contacts[contact].kind == ContactKind::sphere ? -1.0 : 0.0;
  if (which >= kFirstIntrinsic) return 0;  // of a camera
  if (which < 3) {
    const Eigen::Vector3d along = model_.robot_.chain.contacts[contact].place.rotation.col(which);
    return -predicted.direction.dot(model_.common_from_own_.rotation * along);
  }
  // The contact turns by w in its own axes: the point seen from it turns by -w.
  const Eigen::Vector3d turn = contact_turns_[contact].col(which - 3);
  return predicted.gradient.dot(predicted.in_contact.cross(turn));
}

namespace {

// What an image shows of a contact is fixed in this frame, R_A from it.
const Pose& frame_of(const Contact& contact, const Pose& measured, const Pose& at_rest) {
  return contact.on_arm ? measured : at_rest;
}

}  // namespace

// The arm moves either the board, or the camera: then the point moves in its axes as if the arm
// moved it the other way.
void ObservationModel::At::predict_pixel(int row, const Eigen::VectorXd& offset,
                                         Prediction& predicted) const {
  const Touch touch = model_.campaign_.touch[row];
  const ContactPoint& which = model_.contacts_[touch.contact];
  const std::vector<Contact>& contacts = robot_.chain.contacts;
  const Contact &camera = contacts[which.contact], &board = contacts[which.board];
  Intrinsics intrinsics = camera.intrinsics;
  const int first_contact = first_contact_parameter(robot_.chain);
  const auto place_of = [&](int contact) {
    Pose place = frame_of(contacts[contact], predicted.frame, model_.common_from_own_) *
                 contacts[contact].place;
    if (offset.size() == 0) return place;
    const int first = first_contact + kParametersOfContact * contact;
    return place * Pose{rotation_exp(offset.segment<3>(first + 3)), offset.segment<3>(first)};
  };
  if (offset.size() > 0)
    intrinsics += offset.segment<kIntrinsics>(first_contact + kParametersOfContact * which.contact +
                                              kFirstIntrinsic);
  const Pose camera_place = place_of(which.contact);
  const Eigen::Vector3d point = place_of(which.board) * board.points[which.point].position;
  predicted.scale = 1.0;
  predicted.lever = point - predicted.frame.translation;
  predicted.frame.translation = point;
  predicted.in_contact = camera_place.rotation.transpose() * (point - camera_place.translation);
  const PixelReading reading = project(camera.lens, intrinsics, predicted.in_contact);
  const double length = model_.campaign_.metre_per_pixel;
  predicted.gradient = length * reading.by_point.row(touch.axis).transpose();
  predicted.direction = camera_place.rotation * predicted.gradient;
  if (camera.on_arm) predicted.direction = -predicted.direction;
  predicted.position = {length * reading.pixel[touch.axis], 0, 0};
}

// The derivative of a pixel by a parameter of a camera or a board.
double ObservationModel::At::pixel_column(int row, int parameter,
                                          const Prediction& predicted) const {
  const int k = parameter - first_contact_parameter(robot_.chain);
  const int number = k / kParametersOfContact, which = k % kParametersOfContact;
  const Touch touch = model_.campaign_.touch[row];
  const ContactPoint& seen = model_.contacts_[touch.contact];
  const bool of_camera = number == seen.contact;
  if (!of_camera && number != seen.board) return 0;
  const Contact& contact = robot_.chain.contacts[number];
  if (which >= kFirstIntrinsic) {
    if (!of_camera) return 0;
    const PixelReading reading = project(contact.lens, contact.intrinsics, predicted.in_contact);
    return model_.campaign_.metre_per_pixel *
           reading.by_intrinsics(touch.axis, which - kFirstIntrinsic);
  }
  if (which == kFirstIntrinsic - 1) return 0;  // no radius
  // By a motion of the point of the board in R_A; the camera's motion is the opposite one.
  const Eigen::Vector3d by_point =
      robot_.chain.contacts[seen.contact].on_arm ? -predicted.direction : predicted.direction;
  const Eigen::Matrix3d parent =
      frame_of(contact, predicted.frame, model_.common_from_own_).rotation;
  if (which < 3) {
    const Eigen::Vector3d along =
        parent * model_.robot_.chain.contacts[number].place.rotation.col(which);
    return (of_camera ? -1.0 : 1.0) * by_point.dot(along);
  }
  const Eigen::Vector3d turn = contact_turns_[number].col(which - 3);
  if (of_camera) return predicted.gradient.dot(predicted.in_contact.cross(turn));
  const Eigen::Vector3d& point = contact.points[seen.point].position;
  return by_point.dot(parent * (contact.place.rotation * turn.cross(point)));
}

}  // namespace armtrue
