#include "controller/guarded_law.hpp"

#include "controller/guarded_parts.hpp"

namespace multireach::controller {

GuardedLaw::GuardedLaw(const Chain& chain, const GuardedParameters& parameters)
    : parts_(std::make_unique<Parts>(chain, parameters)) {}
GuardedLaw::GuardedLaw(const GuardedLaw& other) : parts_(std::make_unique<Parts>(*other.parts_)) {}
GuardedLaw& GuardedLaw::operator=(const GuardedLaw& other) {
  parts_ = std::make_unique<Parts>(*other.parts_);
  return *this;
}
GuardedLaw::GuardedLaw(GuardedLaw&&) noexcept = default;
GuardedLaw& GuardedLaw::operator=(GuardedLaw&&) noexcept = default;
GuardedLaw::~GuardedLaw() = default;

bool GuardedLaw::start(const JointVector& theta) {
  return parts_->start(theta);
}
Aimed GuardedLaw::aim(const HandTarget& target) {
  return parts_->aim(target);
}
Aimed GuardedLaw::aim(const HandTarget& target, const JointVector& theta_target) {
  return parts_->aim(target, theta_target);
}
Aimed GuardedLaw::follow(const HandTarget& target) {
  return parts_->follow(target);
}
bool GuardedLaw::aim_at_posture(const JointVector& theta) {
  return parts_->aim_at_posture(theta);
}
int GuardedLaw::set_obstacles(std::span<const Obstacle> obstacles) {
  return parts_->set_obstacles(obstacles);
}
void GuardedLaw::take_up(const JointVector& displacement) {
  parts_->take_up(displacement);
}
void GuardedLaw::step() {
  parts_->step();
}

const Chain& GuardedLaw::chain() const {
  return parts_->chain();
}
double GuardedLaw::clearance() {
  return parts_->clearance();
}
bool GuardedLaw::on_detour() const {
  return parts_->on_detour();
}
Eigen::Map<const Eigen::VectorXd> GuardedLaw::theta() const {
  return parts_->theta();
}
Eigen::Map<const Eigen::VectorXd> GuardedLaw::velocity() const {
  return parts_->map(parts_->state().velocity);
}
Eigen::Map<const Eigen::VectorXd> GuardedLaw::theta_target() const {
  return parts_->theta_target();
}
Eigen::Vector3d GuardedLaw::x() const {
  return Eigen::Map<const Eigen::Vector3d>(parts_->state().x.data());
}
Eigen::Vector3d GuardedLaw::x_target() const {
  return Eigen::Map<const Eigen::Vector3d>(parts_->state().x_target.data());
}
JointVector GuardedLaw::weights() const {
  return JointVector::Constant(chain().size(), gamma());
}
double GuardedLaw::gamma() const {
  return parts_->state().gamma;
}
double GuardedLaw::largest_gamma() const {
  return parts_->settings().gamma;
}
double GuardedLaw::residual_m() const {
  return parts_->state().residual;
}
bool GuardedLaw::out_of_reach() const {
  return parts_->out_of_reach();
}
int64_t GuardedLaw::posture_choices() const {
  return parts_->posture_choices();
}
int64_t GuardedLaw::bounded_solves() const {
  return parts_->bounded_solves();
}

}  // namespace multireach::controller
