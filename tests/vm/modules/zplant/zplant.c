// SPDX-License-Identifier: GPL-2.0
/*
 * zplant: a gpio_chip that is a stepper-driven Z axis with a limit switch.
 *
 * STEP/DIR/ENABLE are outputs of the host CPU; LIMIT, the second switch at the
 * other end and the encoder's A and B are inputs with edge interrupts.  Every
 * level change of any line is logged with ktime_get() (CLOCK_MONOTONIC), and the
 * axis position follows the step edges.  Lines without a function here are plain:
 * a light line is logged, an emergency stop is driven by ctl.
 * /sys/kernel/debug/zplant/{state,log,ctl}.
 */
#include <linux/debugfs.h>
#include <linux/gpio/driver.h>
#include <linux/hrtimer.h>
#include <linux/irq_work.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/seq_file.h>
#include <linux/slab.h>
#include <linux/uaccess.h>
#include <linux/version.h>
#include <linux/vmalloc.h>

#define MAXL 64
static char *label = "zplant";
module_param(label, charp, 0444);
#define P(name, def) static int name = def; module_param(name, int, 0444)
P(ngpio, 54);            /* as bcm2835, so the real pin numbers can be used */
P(step, 17); P(dir, 27); P(en, 22); P(limit, 23);
P(light, 24);             /* plain, but told in state */
P(en_low, 1);            /* ENABLE is active low (A4988, DRV8825, TMC) */
P(limit_low, 1);         /* switch pulls the line low when pressed */
P(dir_up, 1);            /* level of DIR that counts the position up */
P(start_pos, 4000);      /* where the axis is at power-up, in steps */
P(limit_pos, 0);         /* switch is pressed at pos <= limit_pos ... */
P(hyst, 0);              /* ... and released at pos > limit_pos + hyst */
P(hard_min, -200);       /* mechanical end stops: steps beyond are lost */
P(hard_max, 200000);
P(bounce_us, 0);         /* contact bounce: time between toggles (4 toggles) */
P(min_high_ns, 1000); P(min_low_ns, 1000); P(dir_setup_ns, 200);
P(limit2, -1);           /* line of the switch at the top, or none */
P(limit2_pos, 130000);   /* pressed at pos >= limit2_pos */
P(enc_a, -1); P(enc_b, -1);   /* lines of the encoder, or none */
P(enc_num, 1); P(enc_den, 4); /* counts are pos * enc_num / enc_den: one at most a step */
P(free_input, 0);        /* 1: a line given back becomes an input and idle, as on a BCM2835; 0: it keeps its level */
P(max_rate, 0);          /* steps/s above which a step is lost; 0: never */
P(log_entries, 262144);

struct ev { u64 t; s32 pos; u16 flags; u8 line; u8 val; } __packed; /* 16 B */
enum { F_LOST_DISABLED = 1, F_LOST_STOP = 2, F_LOST_RATE = 4, F_SHORT_HIGH = 8,
       F_SHORT_LOW = 16, F_DIR_SETUP = 32, F_MOVED = 64 };

static struct zp {
	struct gpio_chip gc;
	raw_spinlock_t lk;
	struct irq_work work;
	struct hrtimer bt;
	struct platform_device *pd;
	struct dentry *d;
	DECLARE_BITMAP(out, MAXL);      /* 1 = output */
	DECLARE_BITMAP(lvl, MAXL);
	DECLARE_BITMAP(unmasked, MAXL);
	DECLARE_BITMAP(pending, MAXL);
	u8 type[MAXL];
	s64 pos, pmin, pmax;
	u64 t_up, t_dn, t_dir, t_step, nstep, nmoved, lost_dis, lost_stop, lost_rate;
	u64 bad_high, bad_low, bad_dir, nlimit, nirq;
	u64 min_period;
	s64 count;                      /* the encoder's */
	u32 skip;                       /* steps to lose */
	bool pressed, dead;
	int stuck;                      /* -1 auto, else forced line level */
	int bounces;
	struct ev *log;
	u32 nlog; u64 dropped;
} z;

static void put(u64 t, int line, int val, int flags)
{
	if (z.nlog < log_entries)
		z.log[z.nlog++] = (struct ev){ t, z.pos, flags, line, val };
	else
		z.dropped++;
}

/* drive an input line; caller holds the lock */
static void drive(u64 t, int line, int val)
{
	if (test_bit(line, z.lvl) == val)
		return;
	assign_bit(line, z.lvl, val);
	put(t, line, val, 0);
	if (line == limit)
		z.nlimit++;
	if (test_bit(line, z.unmasked) &&
	    (z.type[line] & (val ? IRQ_TYPE_EDGE_RISING : IRQ_TYPE_EDGE_FALLING))) {
		set_bit(line, z.pending);
		irq_work_queue(&z.work);
	}
}

/* counts at a position, rounded down also below zero */
static s64 counts_at(s64 pos)
{
	s64 n = pos * enc_num;

	return n >= 0 ? div_s64(n, enc_den) : -div_s64(-n + enc_den - 1, enc_den);
}

static void encoder_levels(u64 t)
{
	drive(t, enc_a, (z.count >> 1) & 1);
	drive(t, enc_b, ((z.count >> 1) ^ z.count) & 1);
}

static void encoder_follow(u64 t)
{
	s64 target = counts_at(z.pos);

	if (enc_a < 0 || enc_b < 0)
		return;
	while (z.count != target) {
		z.count += target > z.count ? 1 : -1;
		encoder_levels(t);
	}
}

static int limit_level(void)
{
	return z.stuck >= 0 ? z.stuck : (z.pressed ? !limit_low : !!limit_low);
}

static void sw_update(u64 t)
{
	bool was = z.pressed;

	if (z.pos <= limit_pos)
		z.pressed = true;
	else if (z.pos > limit_pos + hyst)
		z.pressed = false;
	encoder_follow(t);
	if (limit2 >= 0)
		drive(t, limit2, (z.pos >= limit2_pos) ^ !!limit_low);
	drive(t, limit, limit_level());
	if (was != z.pressed && bounce_us && z.stuck < 0) {
		z.bounces = 4;
		hrtimer_start(&z.bt, ns_to_ktime(bounce_us * 1000ULL), HRTIMER_MODE_REL_HARD);
	}
}

static enum hrtimer_restart bounce(struct hrtimer *t)
{
	unsigned long fl;
	bool more;

	raw_spin_lock_irqsave(&z.lk, fl);
	z.bounces--;
	drive(ktime_get_ns(), limit, (z.bounces & 1) ? !limit_level() : limit_level());
	more = z.bounces > 0;
	raw_spin_unlock_irqrestore(&z.lk, fl);
	if (more)
		hrtimer_forward_now(t, ns_to_ktime(bounce_us * 1000ULL));
	return more ? HRTIMER_RESTART : HRTIMER_NORESTART;
}

static void out_change(u64 t, int line, int val)
{
	int f = 0;

	if (line == step && val) {
		int up = test_bit(dir, z.lvl) == !!dir_up;
		u64 per = z.t_step ? t - z.t_step : ~0ULL;

		z.nstep++;
		if (per < z.min_period)
			z.min_period = per;
		if (z.t_dn && t - z.t_dn < min_low_ns) { f |= F_SHORT_LOW; z.bad_low++; }
		if (z.t_dir && t - z.t_dir < dir_setup_ns) { f |= F_DIR_SETUP; z.bad_dir++; }
		if (z.dead || test_bit(en, z.lvl) == !!en_low) {
			f |= F_LOST_DISABLED; z.lost_dis++;
		} else if (max_rate && per < div_u64(1000000000ULL, max_rate)) {
			f |= F_LOST_RATE; z.lost_rate++;
		} else if (z.skip) {
			f |= F_LOST_RATE; z.lost_rate++; z.skip--;
		} else if (up ? z.pos >= hard_max : z.pos <= hard_min) {
			f |= F_LOST_STOP; z.lost_stop++;
		} else {
			z.pos += up ? 1 : -1;
			z.pmin = min(z.pmin, z.pos); z.pmax = max(z.pmax, z.pos);
			f |= F_MOVED; z.nmoved++;
		}
		z.t_step = z.t_up = t;
	} else if (line == step) {
		if (z.t_up && t - z.t_up < min_high_ns) { f |= F_SHORT_HIGH; z.bad_high++; }
		z.t_dn = t;
	} else if (line == dir) {
		z.t_dir = t;
	}
	put(t, line, val, f);
	if (f & F_MOVED)
		sw_update(t);
}

static int zset(struct gpio_chip *gc, unsigned int o, int v)
{
	unsigned long fl;

	raw_spin_lock_irqsave(&z.lk, fl);
	if (test_bit(o, z.out) && test_bit(o, z.lvl) != !!v) {
		assign_bit(o, z.lvl, !!v);
		out_change(ktime_get_ns(), o, !!v);
	}
	raw_spin_unlock_irqrestore(&z.lk, fl);
	return 0;
}
#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 17, 0)
static void zset_void(struct gpio_chip *gc, unsigned int o, int v) { zset(gc, o, v); }
#endif
static int zget(struct gpio_chip *gc, unsigned int o) { return test_bit(o, z.lvl); }
static int zgetdir(struct gpio_chip *gc, unsigned int o)
{
	return test_bit(o, z.out) ? GPIO_LINE_DIRECTION_OUT : GPIO_LINE_DIRECTION_IN;
}
static int zin(struct gpio_chip *gc, unsigned int o) { clear_bit(o, z.out); return 0; }
static int zout(struct gpio_chip *gc, unsigned int o, int v)
{
	if (o == limit || o == limit2 || o == enc_a || o == enc_b)
		return -EPERM;
	set_bit(o, z.out);
	return zset(gc, o, v);
}

static void zfree(struct gpio_chip *gc, unsigned int o)
{
	if (!free_input || !test_bit(o, z.out))
		return;
	zset(gc, o, o == en && en_low);     /* what the resistors make of it */
	clear_bit(o, z.out);
}

static void fire(struct irq_work *w)
{
	int b;

	for_each_set_bit(b, z.pending, MAXL)
		if (test_and_clear_bit(b, z.pending)) {
			z.nirq++;
			generic_handle_domain_irq(z.gc.irq.domain, b);
		}
}
static void zmask(struct irq_data *d)
{
	struct gpio_chip *gc = irq_data_get_irq_chip_data(d);

	clear_bit(irqd_to_hwirq(d), z.unmasked);
	gpiochip_disable_irq(gc, irqd_to_hwirq(d));
}
static void zunmask(struct irq_data *d)
{
	struct gpio_chip *gc = irq_data_get_irq_chip_data(d);

	gpiochip_enable_irq(gc, irqd_to_hwirq(d));
	set_bit(irqd_to_hwirq(d), z.unmasked);
}
static int ztype(struct irq_data *d, unsigned int t)
{
	if (t & ~IRQ_TYPE_EDGE_BOTH)
		return -EINVAL;
	z.type[irqd_to_hwirq(d)] = t;
	return 0;
}
static const struct irq_chip zirq = {
	.name = "zplant", .irq_mask = zmask, .irq_unmask = zunmask, .irq_set_type = ztype,
	.flags = IRQCHIP_IMMUTABLE, GPIOCHIP_IRQ_RESOURCE_HELPERS,
};

static int state_show(struct seq_file *s, void *u)
{
	unsigned long fl;
	struct zp c;

	raw_spin_lock_irqsave(&z.lk, fl);
	c = z;
	raw_spin_unlock_irqrestore(&z.lk, fl);
	seq_printf(s, "pos %lld\nmin %lld\nmax %lld\npressed %d\nenabled %d\nlimit_level %d\nlight %d\ncount %lld\n",
		   c.pos, c.pmin, c.pmax, c.pressed, test_bit(en, c.lvl) != !!en_low, test_bit(limit, c.lvl), test_bit(light, c.lvl), c.count);
	seq_printf(s, "steps %llu\nmoved %llu\nlost_disabled %llu\nlost_stop %llu\nlost_rate %llu\n",
		   c.nstep, c.nmoved, c.lost_dis, c.lost_stop, c.lost_rate);
	seq_printf(s, "short_high %llu\nshort_low %llu\ndir_setup %llu\nmin_period_ns %lld\n",
		   c.bad_high, c.bad_low, c.bad_dir, c.min_period == ~0ULL ? -1 : (s64)c.min_period);
	seq_printf(s, "limit_edges %llu\nirqs %llu\nlog %u\ndropped %llu\n", c.nlimit, c.nirq, c.nlog, c.dropped);
	return 0;
}
DEFINE_SHOW_ATTRIBUTE(state);

static ssize_t log_read(struct file *f, char __user *b, size_t n, loff_t *o)
{
	return simple_read_from_buffer(b, n, o, z.log, (size_t)READ_ONCE(z.nlog) * sizeof(struct ev));
}
static const struct file_operations log_fops = { .owner = THIS_MODULE, .read = log_read, .llseek = default_llseek };

static void clear(void)
{
	z.pmin = z.pmax = z.pos;
	z.nstep = z.nmoved = z.lost_dis = z.lost_stop = z.lost_rate = 0;
	z.bad_high = z.bad_low = z.bad_dir = z.nlimit = z.nirq = z.dropped = 0;
	z.t_step = z.t_up = z.t_dn = z.t_dir = 0;
	z.min_period = ~0ULL; z.nlog = 0;
}

/* pos N | limit auto|0|1 | motor 0|1 | skip N | in LINE 0|1 | bounce US | reset */
static ssize_t ctl_write(struct file *f, const char __user *ub, size_t n, loff_t *o)
{
	char k[64], w[16], a[16] = "";
	int v = 0, v2 = 0, r = 0;
	unsigned long fl;

	if (n >= sizeof(k) || copy_from_user(k, ub, n))
		return -EINVAL;
	k[n] = 0;
	if (sscanf(k, "%15s %15s %d", w, a, &v2) < 1)
		return -EINVAL;
	if (*a && kstrtoint(a, 0, &v) && strcmp(a, "auto"))
		return -EINVAL;
	raw_spin_lock_irqsave(&z.lk, fl);
	if (!strcmp(w, "pos")) { z.pos = v; sw_update(ktime_get_ns()); }
	else if (!strcmp(w, "limit")) { z.stuck = strcmp(a, "auto") ? !!v : -1; sw_update(ktime_get_ns()); }
	else if (!strcmp(w, "motor")) z.dead = !v;
	else if (!strcmp(w, "skip")) z.skip = v;
	else if (!strcmp(w, "bounce")) bounce_us = v;
	else if (!strcmp(w, "in") && v >= 0 && v < ngpio && !test_bit(v, z.out)) drive(ktime_get_ns(), v, !!v2);
	else if (!strcmp(w, "reset")) clear();
	else r = -EINVAL;
	raw_spin_unlock_irqrestore(&z.lk, fl);
	return r ? r : n;
}
static const struct file_operations ctl_fops = { .owner = THIS_MODULE, .write = ctl_write };

static int __init zinit(void)
{
	struct gpio_irq_chip *g = &z.gc.irq;
	int r;

	if (ngpio > MAXL || step >= ngpio || light >= ngpio || dir >= ngpio || en >= ngpio || limit >= ngpio ||
	    limit2 >= ngpio || enc_a >= ngpio || enc_b >= ngpio || enc_den <= 0 || abs(enc_num) > enc_den)
		return -EINVAL;
	raw_spin_lock_init(&z.lk);
	init_irq_work(&z.work, fire);
#if LINUX_VERSION_CODE >= KERNEL_VERSION(6, 13, 0)
	hrtimer_setup(&z.bt, bounce, CLOCK_MONOTONIC, HRTIMER_MODE_REL_HARD);
#else
	hrtimer_init(&z.bt, CLOCK_MONOTONIC, HRTIMER_MODE_REL_HARD);
	z.bt.function = bounce;
#endif
	z.log = vzalloc(array_size(log_entries, sizeof(struct ev)));
	if (!z.log)
		return -ENOMEM;
	z.pos = start_pos; z.stuck = -1;
	if (en_low) set_bit(en, z.lvl);          /* pull-up: disabled until driven */
	z.pressed = z.pos <= limit_pos;
	assign_bit(limit, z.lvl, limit_level());
	if (limit2 >= 0)
		assign_bit(limit2, z.lvl, (z.pos >= limit2_pos) ^ !!limit_low);
	if (enc_a >= 0 && enc_b >= 0) {
		z.count = counts_at(z.pos);
		encoder_levels(0);
	}
	clear();
	z.pd = platform_device_register_simple("zplant", -1, NULL, 0);
	if (IS_ERR(z.pd)) { vfree(z.log); return PTR_ERR(z.pd); }
	z.gc.label = label; z.gc.parent = &z.pd->dev; z.gc.owner = THIS_MODULE;
	z.gc.base = -1; z.gc.ngpio = ngpio;
	z.gc.get = zget; z.gc.get_direction = zgetdir;
	z.gc.free = zfree;
	z.gc.direction_input = zin; z.gc.direction_output = zout;
#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 17, 0)
	z.gc.set = zset_void;
#else
	z.gc.set = zset;
#endif
	gpio_irq_chip_set_chip(g, &zirq);
	g->handler = handle_simple_irq; g->default_type = IRQ_TYPE_NONE;
	r = gpiochip_add_data(&z.gc, &z);
	if (r) { platform_device_unregister(z.pd); vfree(z.log); return r; }
	z.d = debugfs_create_dir("zplant", NULL);
	debugfs_create_file("state", 0444, z.d, NULL, &state_fops);
	debugfs_create_file("log", 0444, z.d, NULL, &log_fops);
	debugfs_create_file("ctl", 0200, z.d, NULL, &ctl_fops);
	return 0;
}
static void __exit zexit(void)
{
	debugfs_remove_recursive(z.d);
	gpiochip_remove(&z.gc);
	hrtimer_cancel(&z.bt);
	irq_work_sync(&z.work);
	platform_device_unregister(z.pd);
	vfree(z.log);
}
module_init(zinit);
module_exit(zexit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("GPIO chip that models a stepper-driven Z axis with a limit switch");
