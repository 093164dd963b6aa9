#include <stdexcept>

#include "armtrue/kinematics/contact.h"
#include "armtrue/observation/observation.h"

namespace armtrue {

namespace {

// R_A from the frame in which a contact is fixed: the measured frame of what is on the arm, else
// the R_A of the readings.
const Pose& frame_of(const Contact& contact, const Pose& measured, const Pose& at_rest) {
  return contact.on_arm ? measured : at_rest;
}

}  // namespace

void ObservationModel::require_placed(const Contact& contact) const {
  if (is_of_images(contact.kind) && !contact.is_placed)
    throw std::invalid_argument(
        campaign_.source + ": the robot file does not say where '" + contact.name +
        "' is; calibrate the robot on images, with auto or base and tool among what is identified, "
        "or state its place under 'cameras' or 'boards'");
  if (contact.kind == ContactKind::beam && !contact.is_placed)
    throw std::invalid_argument(
        campaign_.source + ": the robot file does not say where the beam '" + contact.name +
        "' is; calibrate the robot on its readings, with auto or tool among what is identified, or "
        "state its place under 'beams'");
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
  if (which.beam >= 0) return require_placed(robot_.chain.contacts[which.beam]);
  if (reads_point(contact, which.point) != (touch.axis >= 0))
    throw std::invalid_argument(campaign_.source + ": the touches of '" + contact.name +
                                "' are not those of bind_touches()");
}

// R_A from the contact, with what effects add to its place.
Pose ObservationModel::At::place_of(int contact, const Pose& measured,
                                    const Eigen::VectorXd& offset) const {
  const Contact& own = robot_.chain.contacts[contact];
  const Pose place = frame_of(own, measured, model_.common_from_own_) * own.place;
  if (offset.size() == 0) return place;
  const int first = first_contact_parameter(robot_.chain) + kParametersOfContact * contact;
  return place * Pose{rotation_exp(offset.segment<3>(first + 3)), offset.segment<3>(first)};
}

// A touch needs no instrument: its scale is 1.
void ObservationModel::At::predict_touch(int row, const Eigen::VectorXd& offset,
                                         Prediction& predicted) const {
  const Touch touch = model_.campaign_.touch[row];
  const ContactPoint which = model_.contacts_[touch.contact];
  const Contact& contact = robot_.chain.contacts[which.contact];
  const Pose place = place_of(which.contact, predicted.frame, offset);
  double growth = 0;  // of the radius
  if (offset.size() > 0 && touch.axis < 0)
    growth =
        offset[first_contact_parameter(robot_.chain) + kParametersOfContact * which.contact + 6];
  predicted.scale = 1.0;
  predicted.in_contact =
      place.rotation.transpose() * (predicted.frame.translation - place.translation);
  const TouchReading reading =
      touch_reading(contact, which.point, touch.axis, predicted.in_contact);
  predicted.gradient = reading.gradient;
  predicted.direction = place.rotation * predicted.gradient;
  predicted.position = {reading.value - growth, 0, 0};
}

// The point of the arm where the beam ends moves as a tool would that touches there.
void ObservationModel::At::predict_beam(int row, const Pose& measured,
                                        const Eigen::VectorXd& offset,
                                        Prediction& predicted) const {
  const ContactPoint which = model_.contacts_[model_.campaign_.touch[row].contact];
  const Pose place = place_of(which.contact, measured, offset);
  const Pose contact_from_beam = inverse(place) * place_of(which.beam, measured, offset);
  const BeamReading reading =
      beam_reading(robot_.chain.contacts[which.contact], which.point, contact_from_beam.translation,
                   contact_from_beam.rotation.col(2));
  predicted.scale = 1.0;
  predicted.in_contact = reading.hit;
  predicted.frame.translation = place * reading.hit;
  predicted.lever = predicted.frame.translation - measured.translation;
  predicted.gradient = reading.gradient;
  predicted.direction = place.rotation * predicted.gradient;
  predicted.position = {reading.value, 0, 0};
}

// The derivative of the reading of a touch or a beam by a parameter of the contact or the beam.
double ObservationModel::At::touch_column(int row, int parameter,
                                          const Prediction& predicted) const {
  const int k = parameter - first_contact_parameter(robot_.chain);
  const int contact = k / kParametersOfContact, which = k % kParametersOfContact;
  const Touch touch = model_.campaign_.touch[row];
  const ContactPoint& touched = model_.contacts_[touch.contact];
  const bool is_beam = contact == touched.beam;
  if ((contact != touched.contact && !is_beam) || which >= kFirstIntrinsic) return 0;
  if (which == 6) return touched.beam < 0 && touch.axis < 0 ? -1.0 : 0.0;
  if (which < 3) {
    const Eigen::Vector3d along = model_.robot_.chain.contacts[contact].place.rotation.col(which);
    const Pose parent =
        frame_of(robot_.chain.contacts[contact], predicted.frame, model_.common_from_own_);
    return (is_beam ? 1.0 : -1.0) * predicted.direction.dot(parent.rotation * along);
  }
  const Eigen::Vector3d turn = contact_turns_[contact].col(which - 3);
  if (is_beam) {
    const Eigen::Matrix3d axes =
        predicted.frame.rotation * robot_.chain.contacts[contact].place.rotation;
    const Eigen::Vector3d end(0, 0, predicted.position[0]);
    return predicted.direction.dot(axes * turn.cross(end));
  }
  // The contact turns by w in its own axes: the point seen from it turns by -w.
  return predicted.gradient.dot(predicted.in_contact.cross(turn));
}

// The arm moves either the board, or the camera: then the point moves in its axes as if the arm
// moved it the other way.
void ObservationModel::At::predict_pixel(int row, const Pose& measured,
                                         const Eigen::VectorXd& offset,
                                         Prediction& predicted) const {
  const Touch touch = model_.campaign_.touch[row];
  const ContactPoint& which = model_.contacts_[touch.contact];
  const std::vector<Contact>& contacts = robot_.chain.contacts;
  const Contact &camera = contacts[which.contact], &board = contacts[which.board];
  Intrinsics intrinsics = camera.intrinsics;
  if (offset.size() > 0)
    intrinsics +=
        offset.segment<kIntrinsics>(first_contact_parameter(robot_.chain) +
                                    kParametersOfContact * which.contact + kFirstIntrinsic);
  const Pose camera_place = place_of(which.contact, measured, offset);
  const Eigen::Vector3d point =
      place_of(which.board, measured, offset) * board.points[which.point].position;
  predicted.scale = 1.0;
  predicted.lever = point - measured.translation;
  predicted.frame.translation = point;
  predicted.in_contact = camera_place.rotation.transpose() * (point - camera_place.translation);
  const PixelReading reading = project(camera.lens, intrinsics, predicted.in_contact);
  const double length = model_.campaign_.metre_per_pixel;
  predicted.by_intrinsics = length * reading.by_intrinsics.row(touch.axis).transpose();
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
  if (which >= kFirstIntrinsic)
    return of_camera ? predicted.by_intrinsics[which - kFirstIntrinsic] : 0;
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
