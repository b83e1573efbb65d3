#include "adapters/mujoco/compiled/load.h"

#include <csetjmp>
#include <cstdio>
#include <mutex>

#include "base/text.h"

namespace fire3dv::convert {
namespace {

std::mutex faults_mutex;  // protects the variables below and MuJoCo's handlers
std::jmp_buf after_fault;
char fault_text[1024];
std::vector<std::string>* warnings_said;

void on_fault(const char* text) {
  std::snprintf(fault_text, sizeof fault_text, "%s", text);
  std::longjmp(after_fault, 1);
}

void on_warning(const char* text) {
  constexpr size_t kMaxWarnings = 100;
  if (warnings_said && warnings_said->size() < kMaxWarnings)
    warnings_said->push_back(std::string("MuJoCo: ") + text);
}

// Installs the handlers while their jump buffer and warning list are valid.
class Handlers {
 public:
  explicit Handlers(std::vector<std::string>* warnings) {
    warnings_said = warnings;
    mju_user_error = on_fault;
    mju_user_warning = on_warning;
  }
  ~Handlers() {
    warnings_said = nullptr;
    mju_user_error = error_before_;
    mju_user_warning = warning_before_;
  }
  Handlers(const Handlers&) = delete;
  Handlers& operator=(const Handlers&) = delete;

 private:
  void (*error_before_)(const char*) = mju_user_error;
  void (*warning_before_)(const char*) = mju_user_warning;
};

std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  for (char& c : text)
    if (c == '\n') c = ' ';
  return text;
}

// No object with a destructor may exist between this frame and the fault.
bool without_fault(void (*call)(void*), void* context) {
  if (setjmp(after_fault) != 0) return false;
  call(context);
  return true;
}

}  // namespace

Result<void> call_mujoco(void (*call)(void*), void* context, std::vector<std::string>* warnings) {
  const std::lock_guard lock(faults_mutex);
  const Handlers handlers(warnings);
  if (!without_fault(call, context)) return Error{one_line(fault_text)};
  return {};
}

Result<MjcfModel> compile_mjcf(const std::filesystem::path& file, std::vector<std::string>* warnings) {
  struct {
    const char* file;
    char text[1024] = "";
    mjModel* model = nullptr;
  } job{file.c_str()};
  const Result<void> done =
      call_mujoco([&job] { job.model = mj_loadXML(job.file, nullptr, job.text, sizeof job.text); }, warnings);
  MjcfModel model(job.model, &mj_deleteModel);
  if (!done) return Error{quote(file.string()) + ": " + done.error().message};
  if (!model) return Error{quote(file.string()) + ": " + one_line(job.text)};
  if (*job.text && warnings) warnings->push_back("MuJoCo: " + one_line(job.text));
  return model;
}

Result<MjcfData> pose_mjcf(const mjModel& model, std::vector<std::string>* warnings) {
  mjData* made = nullptr;
  const Result<void> done = call_mujoco(
      [&] {
        made = mj_makeData(&model);
        if (!made) return;
        if (model.nkey > 0)
          mj_resetDataKeyframe(&model, made, 0);
        else
          mj_resetData(&model, made);
        mj_kinematics(&model, made);
        mj_comPos(&model, made);
        mj_camlight(&model, made);
        mj_tendon(&model, made);
      },
      warnings);
  MjcfData data(made, &mj_deleteData);
  if (!done) return Error{"it cannot be posed: " + done.error().message};
  if (!data) return Error{"it cannot be posed: MuJoCo has no memory for it"};
  return data;
}

}  // namespace fire3dv::convert
