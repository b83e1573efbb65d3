#include "programs/drake/render/render_thread.h"

#include <cstdio>
#include <exception>
#include <new>
#include <utility>

#include "base/log.h"
#include "programs/drake/request/form.h"

namespace fire3dv::drake {
namespace {

const char* name_of(ImageType type) {
  return type == ImageType::color ? "color" : type == ImageType::depth ? "depth" : "label";
}

}  // namespace

RenderThread::RenderThread(ImageRenderer& renderer, std::function<void(const std::string&)> on_failure)
    : renderer_(renderer), on_failure_(std::move(on_failure)), thread_([this] { run(); }) {}

RenderThread::~RenderThread() {
  (void)stop(std::chrono::milliseconds(0));
  thread_.join();
}

void RenderThread::push(HttpRequest&& request, HttpServer::Answer answer) {
  {
    const std::lock_guard lock(mutex_);
    jobs_.push_back({std::move(request), std::move(answer)});
  }
  changed_.notify_all();
}

bool RenderThread::stop(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  stopping_ = true;
  changed_.notify_all();
  return changed_.wait_for(lock, patience, [this] { return ended_; });
}

void RenderThread::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (stopping_) break;
    Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    try {
      job.answer(answer_to(job.request));
    } catch (const std::bad_alloc&) {
      job.answer(http_error(500, "there is no memory for this image"));
    } catch (const std::exception& failure) {  // of Vulkan: the device is lost
      job.answer(http_error(500, failure.what()));
      on_failure_(failure.what());
      lock.lock();
      break;
    }
    job = {};
    lock.lock();
  }
  ended_ = true;
  changed_.notify_all();
}

HttpAnswer RenderThread::answer_to(const HttpRequest& request) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  const Result<RenderRequest> form = read_form(request.body, request.content_type);
  if (!form) return http_error(400, form.error().message);
  Result<RenderedImage> image = renderer_.render(*form);
  if (!image) return http_error(400, image.error().message);
  if (!image->was_cached) {
    char text[160];
    std::snprintf(text, sizeof text, "%s image of a new scene of %.1f MiB in %.0f ms", name_of(form->type),
                  static_cast<double>(form->scene.size()) / (1 << 20),
                  std::chrono::duration<double, std::milli>(Clock::now() - begin).count());
    print_log_line("fire3dv-drake", text);
  }
  return {200, std::move(image->content_type), std::move(image->file)};
}

}  // namespace fire3dv::drake
