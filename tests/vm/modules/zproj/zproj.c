// SPDX-License-Identifier: GPL-2.0
/*
 * zproj: a DRM/KMS device that is a projector's video input.  One CRTC, one primary plane, one HDMI-A
 * connector, dumb buffers, vblank from an hrtimer at the mode's rate.  A flip takes effect at the next
 * vblank and is logged: CLOCK_MONOTONIC ns of that vblank, vblank number, size, CRC-32 (as zlib) of the
 * rows (X byte zeroed) and the number of lit pixels.
 * /sys/kernel/debug/zproj/{log,frame,edid,color,ctl}.  No fbdev emulation, so no console, no cursor.
 */
#include <linux/crc32.h>
#include <linux/debugfs.h>
#include <linux/delay.h>
#include <linux/hrtimer.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/seq_file.h>
#include <linux/uaccess.h>
#include <linux/version.h>
#include <linux/vmalloc.h>
#include <drm/drm_atomic_helper.h>
#include <drm/drm_drv.h>
#include <drm/drm_edid.h>
#include <drm/drm_fourcc.h>
#include <drm/drm_framebuffer.h>
#include <drm/drm_gem_atomic_helper.h>
#include <drm/drm_gem_framebuffer_helper.h>
#include <drm/drm_gem_shmem_helper.h>
#include <drm/drm_managed.h>
#include <drm/drm_modes.h>
#include <drm/drm_probe_helper.h>
#include <drm/drm_simple_kms_helper.h>
#include <drm/drm_vblank.h>

static int width = 1920, height = 1080, refresh = 60, rehash, r8 = 1, atomic = 1, log_entries = 65536, edid_ms, gamma, range = 1;
module_param(width, int, 0444); module_param(height, int, 0444); module_param(refresh, int, 0444);
module_param(rehash, int, 0644);   /* >0: hash again every that many vblanks, log a change (drawing in place) */
module_param(r8, int, 0444);       /* offer R8 next to XRGB8888 and RGB565 */
module_param(atomic, int, 0444);   /* 0: programs find a driver without atomic mode setting */
module_param(log_entries, int, 0444);
module_param(edid_ms, int, 0644);  /* asking the display for its modes takes that long */
module_param(gamma, int, 0444);    /* 1: somebody left a gamma table; 2: it cannot be changed */
module_param(range, int, 0444);    /* 0: no "Broadcast RGB" */

enum { ON = 1, FLIP, REDRAW, OFF, PLUG, UNPLUG };
static const char * const names[] = { "?", "ON", "FLIP", "REDRAW", "OFF", "PLUG", "UNPLUG" };
struct ent { u64 t; u32 seq; u16 type, w, h; u32 crc, lit; };
struct frame {
	struct list_head l; struct drm_framebuffer *fb;
	struct iosys_map map[DRM_FORMAT_MAX_PLANES], data[DRM_FORMAT_MAX_PLANES];
	int ent;
};
static struct zj {
	struct drm_device drm;
	struct drm_simple_display_pipe pipe;
	struct drm_connector conn;
	struct drm_crtc_funcs cf;
	struct hrtimer t;
	spinlock_t lk;
	ktime_t period, last;
	struct frame *pend, *act;
	struct list_head dead;
	struct work_struct work;
	struct mutex wl;                /* the worker and the frame file */
	struct ent *log; u32 nlog;
	u32 seq;
	struct drm_pending_vblank_event *held;
	bool connected, running, lose, hold;
	u8 *edid; size_t edid_n;
} *z;

static int put(u64 t, int type, struct drm_framebuffer *fb)
{
	if (z->nlog >= log_entries)
		return -1;
	z->log[z->nlog] = (struct ent){ t, z->seq, type, fb ? fb->width : 0, fb ? fb->height : 0, 0, 0 };
	return z->nlog++;
}
static void hash(struct frame *f, u32 *crc, u32 *lit)
{
	struct drm_framebuffer *fb = f->fb;
	bool x = fb->format->format == DRM_FORMAT_XRGB8888;
	u32 c = ~0, n = 0, *row = x ? kvmalloc(fb->width * 4, GFP_KERNEL) : NULL;
	int y, i;

	for (y = 0; y < fb->height; y++) {
		u8 *s = (u8 *)f->data[0].vaddr + (size_t)y * fb->pitches[0];

		if (!memchr_inv(s, 0, fb->width * fb->format->cpp[0])) {   /* most rows are black: fast */
			c = crc32_le(c, s, fb->width * fb->format->cpp[0]);
		} else if (x && row) {
			for (i = 0; i < fb->width; i++) { row[i] = ((u32 *)s)[i] & 0xffffff; n += !!row[i]; }
			c = crc32_le(c, (u8 *)row, fb->width * 4);
		} else {
			int k = fb->format->cpp[0];

			for (i = 0; i < fb->width; i++) n += k == 2 ? !!((u16 *)s)[i] : !!s[i];
			c = crc32_le(c, s, fb->width * k);
		}
		if (!(y & 63)) cond_resched();
	}
	kvfree(row);
	*crc = ~c; *lit = n;
}
static void drop(struct frame *f)
{
	drm_gem_fb_vunmap(f->fb, f->map); drm_framebuffer_put(f->fb); kfree(f);
}
static void work(struct work_struct *w)
{
	struct frame *a, *f, *n;
	LIST_HEAD(dead);
	u32 crc, lit;

	mutex_lock(&z->wl);
	spin_lock_irq(&z->lk);
	a = z->act;
	list_splice_init(&z->dead, &dead);
	spin_unlock_irq(&z->lk);
	list_for_each_entry_safe(f, n, &dead, l) {      /* short exposures: hashed late, but hashed */
		if (f->ent >= 0 && !z->log[f->ent].crc) { hash(f, &crc, &lit); z->log[f->ent].lit = lit; z->log[f->ent].crc = crc; }
		drop(f);
	}
	if (a && a->ent >= 0) {                         /* only this worker frees frames: a stays valid */
		struct ent *e = &z->log[a->ent];

		if (!e->crc) {
			hash(a, &crc, &lit); e->lit = lit; e->crc = crc;
		} else if (rehash) {
			hash(a, &crc, &lit);
			if (crc != e->crc) {
				spin_lock_irq(&z->lk);
				a->ent = put(ktime_get_ns(), REDRAW, a->fb);
				spin_unlock_irq(&z->lk);
				if (a->ent >= 0) { z->log[a->ent].lit = lit; z->log[a->ent].crc = crc; }
			}
		}
	}
	mutex_unlock(&z->wl);
}
static enum hrtimer_restart tick(struct hrtimer *t)
{
	unsigned long fl;
	bool w = false;

	spin_lock_irqsave(&z->lk, fl);
	z->last = hrtimer_get_expires(t);               /* the ideal time, not that of the interrupt */
	z->seq++;
	if (z->pend) {
		if (z->act)
			list_add_tail(&z->act->l, &z->dead);
		z->act = z->pend; z->pend = NULL;
		z->act->ent = put(ktime_to_ns(z->last), FLIP, z->act->fb);
		w = true;
	} else if (rehash && z->seq % rehash == 0) {
		w = true;
	}
	spin_unlock_irqrestore(&z->lk, fl);
	if (w)
		schedule_work(&z->work);
	drm_crtc_handle_vblank(&z->pipe.crtc);
	hrtimer_forward_now(t, z->period);
	return HRTIMER_RESTART;
}
static bool get_ts(struct drm_crtc *c, int *err, ktime_t *t, bool irq)
{
	*err = 0; *t = READ_ONCE(z->last);
	return true;
}
static void arm(struct drm_crtc *c)
{
	struct drm_pending_vblank_event *e = c->state->event;

	if (!e)
		return;
	c->state->event = NULL;
	spin_lock_irq(&c->dev->event_lock);
	if (z->hold && e->base.file_priv && !z->held) {         /* a driver that hangs: the kernel waits for it, too */
		z->hold = false; z->held = e;
		spin_unlock_irq(&c->dev->event_lock);
		return;
	}
	if (z->lose && e->base.file_priv) {                     /* as the kernel does when the file is closed */
		z->lose = false;
		list_del(&e->base.pending_link);
		e->base.file_priv->event_space += e->base.event->length;
		e->base.file_priv = NULL;
	}
	if (c->state->active && !drm_crtc_vblank_get(c))
		drm_crtc_arm_vblank_event(c, e);
	else
		drm_crtc_send_vblank_event(c, e);
	spin_unlock_irq(&c->dev->event_lock);
}
static void show(struct drm_framebuffer *fb)
{
	struct frame *f = kzalloc(sizeof(*f), GFP_KERNEL), *old;

	if (!f)
		return;
	f->fb = fb; f->ent = -1; drm_framebuffer_get(fb);
	if (drm_gem_fb_vmap(fb, f->map, f->data)) { drm_framebuffer_put(fb); kfree(f); return; }
	spin_lock_irq(&z->lk);
	old = z->pend; z->pend = f;
	if (old)
		list_add_tail(&old->l, &z->dead);
	spin_unlock_irq(&z->lk);
}
static void p_enable(struct drm_simple_display_pipe *p, struct drm_crtc_state *cs, struct drm_plane_state *ps)
{
	int r = drm_mode_vrefresh(&cs->mode);

	z->period = ns_to_ktime(cs->mode.clock ? div_u64((u64)cs->mode.htotal * cs->mode.vtotal * 1000000ULL, cs->mode.clock) : 1000000000 / (r ?: 60));
	drm_crtc_vblank_on(&p->crtc);
	spin_lock_irq(&z->lk); put(ktime_get_ns(), ON, ps->fb); spin_unlock_irq(&z->lk);
	if (ps->fb)
		show(ps->fb);
	z->running = true; z->last = ktime_get();
	hrtimer_start(&z->t, z->period, HRTIMER_MODE_REL_HARD);
}
static void p_disable(struct drm_simple_display_pipe *p)
{
	hrtimer_cancel(&z->t);
	z->running = false;
	drm_crtc_vblank_off(&p->crtc);
	spin_lock_irq(&z->lk);
	put(ktime_get_ns(), OFF, NULL);
	if (z->act) list_add_tail(&z->act->l, &z->dead);
	if (z->pend) list_add_tail(&z->pend->l, &z->dead);
	z->act = z->pend = NULL;
	spin_unlock_irq(&z->lk);
	schedule_work(&z->work);
	arm(&p->crtc);
}
static void p_update(struct drm_simple_display_pipe *p, struct drm_plane_state *old)
{
	if (p->plane.state->fb && p->crtc.state->active && p->plane.state->fb != old->fb)
		show(p->plane.state->fb);
	arm(&p->crtc);
}
static void let_go(void)
{
	spin_lock_irq(&z->drm.event_lock);
	if (z->held)
		drm_crtc_send_vblank_event(&z->pipe.crtc, z->held);
	z->held = NULL;
	spin_unlock_irq(&z->drm.event_lock);
}
static int p_von(struct drm_simple_display_pipe *p) { return 0; }
static void p_voff(struct drm_simple_display_pipe *p) { }
static const struct drm_simple_display_pipe_funcs pf = {
	.enable = p_enable, .disable = p_disable, .update = p_update, .enable_vblank = p_von, .disable_vblank = p_voff,
};
static int c_modes(struct drm_connector *c)
{
	struct drm_display_mode *m;
	int n;

	if (edid_ms)
		msleep(edid_ms);
	if (z->edid_n) {
		drm_connector_update_edid_property(c, (struct edid *)z->edid);
		return drm_add_edid_modes(c, (struct edid *)z->edid);
	}
	n = drm_add_modes_noedid(c, width, height);
	m = drm_mode_find_dmt(c->dev, width, height, refresh, false) ?: drm_cvt_mode(c->dev, width, height, refresh, false, false, false);
	if (m) { m->type |= DRM_MODE_TYPE_PREFERRED; drm_mode_probed_add(c, m); n++; }
	return n;
}
static enum drm_connector_status c_detect(struct drm_connector *c, bool force)
{
	return z->connected ? connector_status_connected : connector_status_disconnected;
}
static const struct drm_connector_helper_funcs chf = { .get_modes = c_modes };
static const struct drm_connector_funcs cof = {
	.detect = c_detect, .fill_modes = drm_helper_probe_single_connector_modes, .destroy = drm_connector_cleanup,
	.reset = drm_atomic_helper_connector_reset, .atomic_duplicate_state = drm_atomic_helper_connector_duplicate_state,
	.atomic_destroy_state = drm_atomic_helper_connector_destroy_state,
};
static const struct drm_mode_config_funcs mcf = {
	.fb_create = drm_gem_fb_create, .atomic_check = drm_atomic_helper_check, .atomic_commit = drm_atomic_helper_commit,
};
DEFINE_DRM_GEM_FOPS(fops);
static const struct drm_driver drv = {
	.driver_features = DRIVER_MODESET | DRIVER_GEM | DRIVER_ATOMIC, DRM_GEM_SHMEM_DRIVER_OPS, .fops = &fops,
	.name = "zproj", .desc = "projector model", .major = 1,
#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 12, 0)
	.date = "20260101",
#endif
};

static int log_show(struct seq_file *s, void *u)
{
	u32 i, n = READ_ONCE(z->nlog);

	for (i = 0; i < n; i++) {
		struct ent *e = &z->log[i];

		seq_printf(s, "%llu %u %s %ux%u %08x %u\n", e->t, e->seq, names[e->type], e->w, e->h, e->crc, e->lit);
	}
	return 0;
}
DEFINE_SHOW_ATTRIBUTE(log);
static ssize_t frame_read(struct file *fi, char __user *b, size_t n, loff_t *o)
{
	ssize_t r = 0;

	mutex_lock(&z->wl);
	if (z->act)
		r = simple_read_from_buffer(b, n, o, z->act->data[0].vaddr, (size_t)z->act->fb->height * z->act->fb->pitches[0]);
	mutex_unlock(&z->wl);
	return r;
}
static const struct file_operations frame_fops = { .owner = THIS_MODULE, .read = frame_read, .llseek = default_llseek };
static ssize_t edid_write(struct file *f, const char __user *b, size_t n, loff_t *o)
{
	u8 *e;

	if (n % 128 || n > 512)
		return -EINVAL;
	e = memdup_user(b, n);
	if (IS_ERR(e))
		return PTR_ERR(e);
	z->edid = e; z->edid_n = n;     /* the old one is leaked: a reader may have it */
	drm_kms_helper_hotplug_event(&z->drm);
	return n;
}
static const struct file_operations edid_fops = { .owner = THIS_MODULE, .write = edid_write };
static int c_gamma(struct drm_crtc *c, u16 *r, u16 *g, u16 *b, u32 n, struct drm_modeset_acquire_ctx *x)
{
	int i;

	for (i = 0; gamma == 2 && i < n; i++)           /* the caller has stored what it was given */
		r[i] = g[i] = b[i] = i * i;
	return gamma == 2 ? -EIO : 0;
}
static int color_show(struct seq_file *s, void *u)      /* what black, middle grey and white become; the range */
{
	struct drm_crtc *c = &z->pipe.crtc;
	u32 range_now;

	drm_modeset_lock(&z->drm.mode_config.connection_mutex, NULL);
	range_now = z->conn.state->hdmi.broadcast_rgb;
	drm_modeset_unlock(&z->drm.mode_config.connection_mutex);
	seq_printf(s, "gamma %04x %04x %04x range %s\n", c->gamma_store[0], c->gamma_store[128], c->gamma_store[255],
		   drm_hdmi_connector_get_broadcast_rgb_name(range_now));
	return 0;
}
DEFINE_SHOW_ATTRIBUTE(color);
/*
 * plug | unplug | reset | announce (that something changed) | lose (the next flip's event, which only the program
 * misses) | hold (it, which the kernel waits for, too) | free (what is held)
 */
static ssize_t ctl_write(struct file *f, const char __user *ub, size_t n, loff_t *o)
{
	char k[16] = "";

	if (n >= sizeof(k) || copy_from_user(k, ub, n))
		return -EINVAL;
	if (!strncmp(k, "reset", 5)) {
		flush_work(&z->work);
		mutex_lock(&z->wl); spin_lock_irq(&z->lk); z->nlog = 0; if (z->act) z->act->ent = -1; spin_unlock_irq(&z->lk); mutex_unlock(&z->wl);
		return n;
	}
	if (!strncmp(k, "announce", 8)) { drm_kms_helper_hotplug_event(&z->drm); return n; }
	if (!strncmp(k, "lose", 4)) { z->lose = true; return n; }
	if (!strncmp(k, "hold", 4)) { z->hold = true; return n; }
	if (!strncmp(k, "free", 4)) { let_go(); return n; }
	z->connected = !strncmp(k, "plug", 4);
	spin_lock_irq(&z->lk); put(ktime_get_ns(), z->connected ? PLUG : UNPLUG, NULL); spin_unlock_irq(&z->lk);
	drm_kms_helper_hotplug_event(&z->drm);
	return n;
}
static const struct file_operations ctl_fops = { .owner = THIS_MODULE, .write = ctl_write };

static int __init zinit(void)
{
	static const u32 fmt[] = { DRM_FORMAT_XRGB8888, DRM_FORMAT_RGB565, DRM_FORMAT_R8 };
	struct platform_device *pd = platform_device_register_simple("zproj", -1, NULL, 0);
	struct dentry *d;
	int r, i;

	if (IS_ERR(pd))
		return PTR_ERR(pd);
	if (!devres_open_group(&pd->dev, NULL, GFP_KERNEL))
		return -ENOMEM;
	r = dma_coerce_mask_and_coherent(&pd->dev, DMA_BIT_MASK(64));
	z = devm_drm_dev_alloc(&pd->dev, &drv, struct zj, drm);
	if (IS_ERR(z))
		return PTR_ERR(z);
	if (!atomic)
		z->drm.driver_features &= ~DRIVER_ATOMIC;
	spin_lock_init(&z->lk); mutex_init(&z->wl); INIT_LIST_HEAD(&z->dead); INIT_WORK(&z->work, work); z->connected = true;
	z->log = vzalloc(array_size(log_entries, sizeof(struct ent)));
#if LINUX_VERSION_CODE >= KERNEL_VERSION(6, 13, 0)
	hrtimer_setup(&z->t, tick, CLOCK_MONOTONIC, HRTIMER_MODE_REL_HARD);
#else
	hrtimer_init(&z->t, CLOCK_MONOTONIC, HRTIMER_MODE_REL_HARD); z->t.function = tick;
#endif
	r = drmm_mode_config_init(&z->drm);
	z->drm.mode_config.funcs = &mcf;
	z->drm.mode_config.min_width = z->drm.mode_config.min_height = 16;
	z->drm.mode_config.max_width = z->drm.mode_config.max_height = 16384;
	drm_connector_helper_add(&z->conn, &chf);
	r = r ?: drm_connector_init(&z->drm, &z->conn, &cof, DRM_MODE_CONNECTOR_HDMIA);
	z->conn.polled = DRM_CONNECTOR_POLL_HPD;
	r = r ?: drm_simple_display_pipe_init(&z->drm, &z->pipe, &pf, fmt, r8 ? 3 : 2, NULL, &z->conn);
	if (r)
		return r;
	z->cf = *z->pipe.crtc.funcs; z->cf.get_vblank_timestamp = get_ts; z->cf.gamma_set = c_gamma; z->pipe.crtc.funcs = &z->cf;
	r = drm_mode_crtc_set_gamma_size(&z->pipe.crtc, 256);
	for (i = 0; gamma && i < 3 * 256; i++)
		z->pipe.crtc.gamma_store[i] = (i % 256) * (i % 256);
	r = r ?: drm_vblank_init(&z->drm, 1);
	if (range)
		r = r ?: drm_connector_attach_broadcast_rgb_property(&z->conn);
	drm_mode_config_reset(&z->drm);
	r = r ?: drm_dev_register(&z->drm, 0);
	if (r)
		return r;
	d = debugfs_create_dir("zproj", NULL);
	debugfs_create_file("log", 0444, d, NULL, &log_fops);
	debugfs_create_file("frame", 0444, d, NULL, &frame_fops);
	debugfs_create_file("edid", 0200, d, NULL, &edid_fops);
	debugfs_create_file("color", 0444, d, NULL, &color_fops);
	debugfs_create_file("ctl", 0200, d, NULL, &ctl_fops);
	return 0;
}
module_init(zinit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("DRM device that models a projector's video input and logs what it was shown");
