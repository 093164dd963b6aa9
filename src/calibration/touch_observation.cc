#include <stdexcept>

#include "armtrue/calibration/observation.h"
#include "armtrue/kinematics/contact.h"

namespace armtrue {

// Throws unless the contact has a place and the touch the axis that its kind needs.
void ObservationModel::require_bound(const Touch& touch) const {
  const Contact& contact = robot_.chain.contacts[contacts_[touch.contact].contact];
  if (!contact.is_placed)
    throw std::invalid_argument(
        campaign_.source + ": the robot file does not say where the contact '" + contact.name +
        "' is; calibrate the robot on readings that touch it, with auto or base among what is "
        "identified, or state its place under 'contacts'");
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
  if (which < 3) {
    const Eigen::Vector3d along = model_.robot_.chain.contacts[contact].place.rotation.col(which);
    return -predicted.direction.dot(model_.common_from_own_.rotation * along);
  }
  // The contact turns by w in its own axes: the point seen from it turns by -w.
  const Eigen::Vector3d turn = contact_turns_[contact].col(which - 3);
  return predicted.gradient.dot(predicted.in_contact.cross(turn));
}

}  // namespace armtrue
